#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How well regressions do that certify nothing, on the problems of the tables lasa_table and abc_ds_benchmark.

    experiments/baselines.py --data DATA [--out FILE] [CONFIG ...]

CONFIG is a configuration such as lasa/Sine; without one, all of experiments/configs/lasa and abc_ds. FILE is
experiments/results/baselines.json unless --out names another. Two regressions xdot = f(x):

- gaussian_process: the posterior mean of a Gaussian process, one kernel for all velocity components;
- gaussian_mixture: Gaussian mixture regression, by scikit-learn. SEDS and LPV-DS are mixtures of this form, with
  constraints that make the goal stable. Here there are none.

Each is fitted to every 8th sample of the training demonstrations. Its settings are those with the least error when
training demonstrations are left out. For each of five fixed splits of the seven demonstrations:

- mse: mean of |f(x) - xdot|^2 over all samples of the test demonstrations, normalised as the configuration says;
- dtw: the DTW of s2nnds (sum of distances along the warping path / its number of pairs) of motions from the test
  demonstrations' first points at their times;
- arrive, safe: of motions from a grid of 20 x 20 starts outside the obstacle, the share that reaches the goal
  (0.02) within 40 of normalised time, and the share that neither enters the obstacle nor leaves the workspace. A
  motion slower than 0.001 has stopped.

Needs Debian's python3-sklearn and python3-scipy. All seven demonstrations of a motion are read from LASA's .mat files.
"""

import argparse
import glob
import json
import os
import re
import sys
import tomllib

import numpy as np
import scipy.integrate
import scipy.io
import scipy.linalg
import scipy.special

HERE = os.path.dirname(os.path.abspath(__file__))
SPLITS = [(0, 1), (2, 3), (4, 5), (6, 0), (1, 5)]  # the test demonstrations, as in the drivers
THINNING = 8
GOAL_RADIUS, DURATION, STOPPED = 0.02, 40.0, 1e-3


class GaussianProcess:
    """Posterior mean of a Gaussian process: prior mean 0, variance 1, squared exponential kernel."""

    SETTINGS = [(length, noise) for length in (0.05, 0.1, 0.2, 0.35) for noise in (0.1, 0.3, 0.8)]

    def __init__(self, position, velocity, setting):
        self.length, noise = setting
        self.position = position
        covariance = self.kernel(position) + noise**2 * np.eye(len(position))
        self.weights = scipy.linalg.solve(covariance, velocity, assume_a="pos")

    def kernel(self, x):
        square = (x**2).sum(1)[:, None] + (self.position**2).sum(1) - 2.0 * x @ self.position.T
        return np.exp(-0.5 / self.length**2 * square)

    def __call__(self, x):
        return self.kernel(x) @ self.weights


class GaussianMixture:
    """The mean velocity at a position under a mixture of Gaussians of both (Cohn, Ghahramani and Jordan, 1996)."""

    SETTINGS = [3, 5, 7, 10, 14]  # components

    def __init__(self, position, velocity, setting):
        from sklearn.mixture import GaussianMixture as Mixture

        mixture = Mixture(setting, reg_covar=1e-5, random_state=0).fit(np.hstack([position, velocity]))
        n = position.shape[1]
        covariance = mixture.covariances_
        precision = np.linalg.inv(covariance[:, :n, :n])
        self.position, self.velocity = mixture.means_[:, :n], mixture.means_[:, n:]
        self.slope = covariance[:, n:, :n] @ precision  # [K, n, n]
        self.precision = precision
        self.log_scale = np.log(mixture.weights_) + 0.5 * np.linalg.slogdet(precision)[1]

    def __call__(self, x):
        difference = x[:, None] - self.position  # [N, K, n]
        square = np.einsum("nki,kij,nkj->nk", difference, self.precision, difference)
        share = scipy.special.softmax(self.log_scale - 0.5 * square, axis=1)
        return np.einsum("nk,nki->ni", share, self.velocity + np.einsum("kij,nkj->nki", self.slope, difference))


METHODS = {"gaussian_process": GaussianProcess, "gaussian_mixture": GaussianMixture}


def squared_error(f, demonstrations):
    position, velocity = stacked(demonstrations)
    return float(((f(position) - velocity) ** 2).sum(1).mean())


def stacked(demonstrations, step=1):
    """Every step-th sample of each: positions and velocities."""
    return tuple(np.concatenate([d[key][::step] for d in demonstrations]) for key in ("position", "velocity"))


def fit(method, train):
    """The method with the setting of least error on three training demonstrations, each left out in turn."""

    def error_left_out(setting):
        errors = []
        for k in range(min(3, len(train))):
            f = method(*stacked(train[:k] + train[k + 1 :], 2 * THINNING), setting)
            position, velocity = (train[k][key][::THINNING] for key in ("position", "velocity"))
            errors.append(((f(position) - velocity) ** 2).sum(1).mean())
        return np.mean(errors)

    return method(*stacked(train, THINNING), min(method.SETTINGS, key=error_left_out))


def dtw(a, b):
    """Least sum of distances along a warping path of curves [M, n] and [K, n] / pairs of the shortest such path."""
    distance = np.linalg.norm(a[:, None] - b[None], axis=2)
    rows, columns = distance.shape
    # Along the diagonals i + j = d, where entry i + 1 belongs to row i: all of one depend on the two before only.
    cost, length = np.full((2, rows + 1), np.inf), np.zeros((2, rows + 1))
    cost[0][0] = 0.0
    for d in range(rows + columns - 1):
        i = np.arange(max(0, d - columns + 1), min(rows, d + 1))
        costs = np.stack([cost[0][i], cost[1][i], cost[1][i + 1]])  # both advance, a does, b does
        lengths = np.stack([length[0][i], length[1][i], length[1][i + 1]])
        least = costs.min(0)
        new_cost, new_length = np.full(rows + 1, np.inf), np.zeros(rows + 1)
        new_cost[i + 1] = least + distance[i, d - i]
        new_length[i + 1] = np.where(costs == least, lengths, np.inf).min(0) + 1
        cost, length = [cost[1], new_cost], [length[1], new_length]
    return float(cost[1][rows] / length[1][rows])


def rolled_out(f, demonstration):
    """The motion from its first point at its times, [M, n]; NaN after a failure."""
    times = demonstration["time"] - demonstration["time"][0]
    found = scipy.integrate.solve_ivp(
        lambda _, x: f(x[None])[0],
        (0.0, times[-1]),
        demonstration["position"][0],
        t_eval=times,
        rtol=1e-6,
        atol=1e-6,
    )
    path = np.full_like(demonstration["position"], np.nan)
    path[: found.y.shape[1]] = found.y.T
    return path


def shares(f, problem, cells=20, step=0.05):
    """(share that arrives, share that stays safe) of motions from cell centres outside the obstacle."""
    side = problem["workspace"] * ((np.arange(cells) + 0.5) / cells * 2 - 1)
    x = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    x = x[problem["unsafe"](x) > 0.0]
    count, arrived, lost = len(x), 0, 0
    velocity = f(x)
    for _ in range(round(DURATION / step)):
        k2 = f(x + 0.5 * step * velocity)
        k3 = f(x + 0.5 * step * k2)
        end = x + step / 6.0 * (velocity + 2.0 * k2 + 2.0 * k3 + f(x + step * k3))  # Runge-Kutta
        velocity_there = f(end)
        arriving, leaving = np.zeros(len(x), bool), np.zeros(len(x), bool)
        for s in np.arange(1, 11) / 10:  # a speed is about 1 at most, so the looks are 0.005 apart
            r = 1.0 - s
            at = r * r * (1 + 2 * s) * x + s * s * (3 - 2 * s) * end
            at += step * s * r * (r * velocity - s * velocity_there)
            bad = ~((problem["unsafe"](at) > 0.0) & (np.abs(at).max(1) < problem["reach"]))
            leaving |= bad & ~arriving
            arriving |= (np.linalg.norm(at, axis=1) <= GOAL_RADIUS) & ~leaving
        arrived, lost = arrived + arriving.sum(), lost + leaving.sum()
        going = ~arriving & ~leaving & (np.linalg.norm(velocity_there, axis=1) > STOPPED)
        x, velocity = end[going], velocity_there[going]
        if len(x) == 0:
            break
    return arrived / count, 1.0 - lost / count


def level_of(region, data):
    """The level function of an obstacle in a configuration: [N, 2] -> [N], <= 0 inside."""
    kind = region["type"]
    if kind == "ball":
        return lambda x: np.linalg.norm(x - region["center"], axis=1) - region["radius"]
    if kind == "box":
        lower, upper = np.array(region["lower"]), np.array(region["upper"])
        return lambda x: np.maximum(lower - x, x - upper).max(1)
    if kind not in ("expression", "polynomial"):
        raise SystemExit(f"baselines.py: found an obstacle of type {kind}; expected ball, box, expression or polynomial")
    if "file" in region:
        with open(os.path.join(data, region["file"]), encoding="utf-8") as file:
            published = json.load(file)
        terms = zip(published["coefs"], published["monomials"])
        text = " + ".join(f"({c!r})*{m}" for c, m in terms).replace("xi(1)", "x").replace("xi(2)", "y")
    else:
        text = region["level"]
    if not re.fullmatch(r"(?:x|y|max|min|[-+*/^(),.\d\s]|\d[eE][-+]?\d)*", text):
        raise SystemExit(f"baselines.py: found the level '{text}'; expected + - * / ^ ** max min of x, y and numbers")
    code = compile(text.replace("^", "**"), "level", "eval")
    names = {"max": lambda *a: np.maximum.reduce(a), "min": lambda *a: np.minimum.reduce(a), "__builtins__": {}}
    sign = region.get("sign", 1.0)
    return lambda x: sign * eval(code, names, {"x": x[:, 0], "y": x[:, 1]})


def read_problem(config, data):
    with open(os.path.join(HERE, "configs", config + ".toml"), "rb") as file:
        values = tomllib.load(file)
    problem = values["problem"]
    workspace = problem.get("workspace", 1.25)
    return {
        "demonstrations": read_lasa(os.path.join(data, values["data"]["file"]), values["data"]["normalization"]),
        "unsafe": level_of(problem["unsafe"], data),
        "workspace": workspace,
        "reach": (problem.get("containment", 0.985) or 1.0) * workspace,  # 0: the workspace has no margin
    }


def read_lasa(path, normalization):
    """The demonstrations in normalised units: time [M], position and velocity [M, 2]."""
    raw = scipy.io.loadmat(path, squeeze_me=True, struct_as_record=False)["demos"]
    size = (lambda a: np.abs(a).max()) if normalization == "max_abs" else (lambda a: np.linalg.norm(a, axis=0).max())
    position, velocity = max(size(d.pos) for d in raw), max(size(d.vel) for d in raw)
    return [
        {"time": d.t * velocity / position, "position": d.pos.T / position, "velocity": d.vel.T / velocity} for d in raw
    ]


def measure(method, problem):
    """The figures of a method over the splits: lists of one figure a split."""
    figures = {"mse": [], "dtw": [], "arrive": [], "safe": []}
    for pair in SPLITS:
        test = [problem["demonstrations"][k] for k in pair]
        f = fit(method, [d for k, d in enumerate(problem["demonstrations"]) if k not in pair])
        figures["mse"].append(squared_error(f, test))
        figures["dtw"].append(float(np.mean([dtw(rolled_out(f, d), d["position"]) for d in test])))
        arrive, safe = shares(f, problem)
        figures["arrive"].append(float(arrive))
        figures["safe"].append(float(safe))
    return figures


def table_of(results):
    rows = []
    for config, methods in results.items():
        for name, figures in methods.items():
            mean = {key: np.mean(values) for key, values in figures.items()}
            rows.append(
                [config, name.replace("_", " "), f"{mean['mse']:.4f}", f"{min(figures['mse']):.4f}"]
                + [f"{mean['dtw']:.4f}", f"{mean['arrive']:.3f}", f"{mean['safe']:.3f}"]
            )
    return {"head": ["motion", "regression", "test MSE", "best", "test DTW", "arrive", "safe"], "rows": rows}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--data", required=True, help="folder that has lasa/ and abc_ds/")
    parser.add_argument("--out", default=os.path.join(HERE, "results/baselines.json"))
    parser.add_argument("configs", nargs="*", metavar="CONFIG")
    options = parser.parse_args()
    try:
        import sklearn
    except ImportError:
        print("baselines.py: found no scikit-learn; install Debian's python3-sklearn", file=sys.stderr)
        return 1
    every = sorted(glob.glob(os.path.join(HERE, "configs", "lasa", "*.toml")))
    every += sorted(glob.glob(os.path.join(HERE, "configs", "abc_ds", "*.toml")))
    configs = options.configs or [os.path.relpath(path, os.path.join(HERE, "configs"))[:-5] for path in every]
    results = {}
    for config in configs:
        problem = read_problem(config, options.data)
        results[config] = {name: measure(method, problem) for name, method in METHODS.items()}
        for row in table_of({config: results[config]})["rows"]:
            print("  ".join(row), flush=True)
    found = {
        "splits": SPLITS,
        "versions": {"numpy": np.__version__, "scipy": scipy.__version__, "scikit-learn": sklearn.__version__},
        "motions": results,
        "tables": {"baselines": table_of(results)},
    }
    with open(options.out, "w", encoding="utf-8") as file:
        json.dump(found, file, indent=1)
        file.write("\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
