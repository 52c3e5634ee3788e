#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Policies without any guarantee behind the shield of a certified run, executed as its model says.

The policies: `imitation`, the same network fitted to the demonstrations without conditions; `random walk`, velocities that
forget their direction in 0.3 s; `into the obstacle`, someone who steers straight to its middle. Each moves from the same
starts in the safe set without and with the shield. Writes run files, results.json and shield_study.png below --out, and
prints the table: shares of motions that leave the safe set, meet the obstacle and end within 0.05 of the goal, the share of
readings at which the shield changed something, and its mean change as a share of the mean speed.

    experiments/shield_study.py --out FOLDER [--config experiments/configs/lasa/Sine.toml] [--data DIR] [--motions 100]
"""
import argparse
import json
import pathlib
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "build/release/python"))
import s2nnds  # noqa: E402
from s2nnds import plot_run  # noqa: E402
PROGRAM = ROOT / "build/release/experiments/s2nnds"

# Every reading is a millisecond after the last one and at most that old; lengths and velocities are normalised.
PERIOD = 0.001
MODEL = {"unit": "normalised", "period": PERIOD, "delay": PERIOD, "position_error": 0.0005, "velocity_error": 0.004}
WALKED = "#8d5524"


def train(arguments, out, *words):
    data = ["--data", arguments.data] if arguments.data else []
    done = subprocess.run([str(PROGRAM), "train", arguments.config, "--out", str(out), *data, *words], capture_output=True,
                          text=True)
    if done.returncode not in (0, 3):
        sys.exit(done.stderr.strip())


def runs_of(arguments):
    """The certified run, with a shield, and the same f without conditions."""
    certified, free = arguments.out / "certified.h5", arguments.out / "imitation.h5"
    execution = [f"execution.{key}={json.dumps(value)}" for key, value in MODEL.items()]
    if not certified.exists():
        train(arguments, certified, "--until", "certified", "--set", *execution)
    if not free.exists():
        train(arguments, free, "--set", 'profile="imitation"')
    run = s2nnds.Run(certified)
    if not run.certificate["execution"].get("shielded"):
        sys.exit(f"shield_study.py: found no certified shield in {certified}: {run.certificate['statement']}")
    return run, s2nnds.Run(free)


class RandomWalk:
    def __init__(self, count, dimension, speed, random):
        self.speed, self.random = speed / np.sqrt(dimension), random
        self.velocity = self.speed * random.normal(size=(count, dimension))

    def __call__(self, x):
        kept = np.exp(-PERIOD / 0.3)
        self.velocity = kept * self.velocity + np.sqrt(1 - kept**2) * self.speed * self.random.normal(size=x.shape)
        return self.velocity


def towards(place, speed):
    def steer(x):
        way = place - x
        return speed * way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)

    return steer


def executed(run, policy, starts, steps, shielded, unsafe_level, random):
    """Paths [steps + 1, N, n] in the data's unit; who left, who met the obstacle; share and mean size of changes, mean speed."""
    data = run.data
    x, previous = starts.copy(), starts.copy()
    paths, left, met = [x], np.zeros(len(x), bool), np.zeros(len(x), bool)
    touched = change_sum = speed_sum = 0.0
    for _ in range(steps):
        off = random.normal(size=x.shape)
        off *= data.position_scale * MODEL["position_error"] / np.linalg.norm(off, axis=1, keepdims=True)
        reading = previous + off
        command = policy(reading)
        if shielded:
            command, change = run.shield(reading, command)
            touched, change_sum = touched + np.mean(change > 0), change_sum + np.mean(change)
        speed_sum += np.mean(np.linalg.norm(command, axis=1))
        push = random.normal(size=x.shape)
        push *= data.velocity_scale * MODEL["velocity_error"] / np.linalg.norm(push, axis=1, keepdims=True)
        previous, x = x, x + PERIOD * (command + push)
        paths.append(x)
        z = data.to_normalized(x)
        left |= ~((run.B(z) <= 0) & np.all((z >= run.problem.workspace_lower) & (z <= run.problem.workspace_upper), axis=1))
        met |= unsafe_level(z) <= 0
    return np.stack(paths), left, met, touched / steps, change_sum / steps, speed_sum / steps


def starts_in(run, count, random):
    lower, upper = run.problem.workspace_lower, run.problem.workspace_upper
    z = random.uniform(lower, upper, (200 * count, run.dimension))
    return run.data.to_data(z[run.B(z) < -0.01][:count])


def study(arguments):
    run, free = runs_of(arguments)
    data = run.data
    problem = s2nnds.Problem(arguments.config, data=arguments.data or "")
    fastest = data.velocity_scale * run.certificate["execution"]["most_command"]
    inside = [np.stack(np.meshgrid(*run.grid.axes, indexing="ij"), axis=-1)[run.grid.unsafe <= 0]]
    middle = data.to_data(np.mean(inside[0], axis=0))
    starts = starts_in(run, arguments.motions, np.random.default_rng(1))
    steps = int(arguments.seconds / PERIOD)
    policies = {
        "imitation": lambda: free.velocity,
        "random walk": lambda: RandomWalk(len(starts), run.dimension, 0.5 * fastest, np.random.default_rng(2)),
        "into the obstacle": lambda: towards(middle, 0.5 * fastest),
    }
    rows, shown = [], {}
    for name, policy in policies.items():
        for shielded in (False, True):
            found = executed(run, policy(), starts, steps, shielded, problem.unsafe_level, np.random.default_rng(3))
            paths, left, met, touched, change, speed = found
            arrived = np.linalg.norm(data.to_normalized(paths[-1]), axis=1) < 0.05
            rows.append({"policy": name, "shield": shielded, "motions": len(starts), "leave": float(left.mean()),
                         "meet": float(met.mean()), "arrive": float(arrived.mean()), "changed": float(touched),
                         "mean_change": float(change / speed)})
            shown[name, shielded] = paths, left, met
    return run, rows, shown


def figure(run, shown, path):
    shown_run = run.in_data_unit()
    names = list(dict.fromkeys(name for name, _ in shown))
    drawing, axes = plt.subplots(2, len(names), figsize=(4.2 * len(names), 8.6), constrained_layout=True, sharex=True,
                                 sharey=True, squeeze=False)
    for (name, shielded), (paths, left, _) in shown.items():
        ax = axes[int(shielded), names.index(name)]
        handles = plot_run.draw_sets(ax, *shown_run.grid.axes, shown_run.grid.unsafe, None, shown_run.grid.B)
        for k in range(0, paths.shape[1], max(1, paths.shape[1] // 40)):
            ax.plot(*paths[::20, k].T, color="#6a1b9a" if left[k] else WALKED, linewidth=0.7, zorder=6)
        plot_run.draw_goal(ax, shown_run)
        plot_run.frame(ax, shown_run)
        ax.set_title(f"{name}, {'with' if shielded else 'without'} the shield")
    handles += [plot_run.line("stays in {B ≤ 0}", WALKED), plot_run.line("leaves it", "#6a1b9a"), plot_run.goal_handle()]
    plot_run.legend_below(drawing, handles, 5)
    plot_run.save(drawing, path, "png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--config", default=str(ROOT / "experiments/configs/lasa/Sine.toml"))
    parser.add_argument("--data")
    parser.add_argument("--motions", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=8.0)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    run, rows, shown = study(arguments)
    (arguments.out / "results.json").write_text(json.dumps(rows, indent=1))
    print("| policy | shield | motions | leave {B <= 0} | meet the obstacle | arrive | changed | mean change |")
    print("|---|---|---|---|---|---|---|---|")
    for row in rows:
        changed = f"{row['changed']:.3f} | {row['mean_change']:.3f}" if row["shield"] else "- | -"
        print(f"| {row['policy']} | {'with' if row['shield'] else 'without'} | {row['motions']} | {row['leave']:.2f} | "
              f"{row['meet']:.2f} | {row['arrive']:.2f} | {changed} |")
    with plt.rc_context(plot_run.STYLE):
        figure(run, shown, arguments.out / "shield_study.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
