#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Table I's motions with their obstacles displaced: what one certificate covers (`s2nnds range`), and what `adapt` takes instead.

Trains each motion to its first certificate (seed 0, below --out, unless it is there), writes displaced_obstacle.png and, with
--write, experiments/results/displaced_obstacle.json, from which readme_tables.py makes the table.

    experiments/displaced_obstacle.py --data DIR --out FOLDER [--adapt 4] [--write]
"""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "build/release/python"))
sys.path.insert(1, str(ROOT / "notebooks_export/python"))
from s2nnds.run import Run  # noqa: E402
PROGRAM = ROOT / "build/release/experiments/s2nnds"
MOTIONS = ("Sine", "Sshape", "CShape", "Worm", "Angle", "GShape", "PShape", "NShape")


def called(*words):
    """The program's answer as an object; None and its complaint where it refuses."""
    done = subprocess.run([str(PROGRAM), *map(str, words), "--json"], capture_output=True, text=True)
    if done.returncode == 2:
        return None, done.stderr.strip().splitlines()[-1]
    if done.returncode not in (0, 3):
        sys.exit(done.stderr.strip())
    return json.loads(done.stdout.strip().splitlines()[-1]), ""


def displaced_settings(run, p):
    """What `adapt` has to be told; None where the obstacle is no ball and no box."""
    unsafe = {key.removeprefix("problem.unsafe."): value for key, value in run.config.items() if "problem.unsafe." in key}
    keys = {"ball": ("center",), "box": ("lower", "upper")}.get(str(unsafe["type"]).strip(chr(34)), ())
    return [word for key in keys
            for word in ("--set", f"problem.unsafe.{key}={np.round(np.array(json.loads(unsafe[key])) + p, 6).tolist()}")]


def adapted(path, run, size, count, folder):
    """(outcome, seconds) of `adapt` for displacements in random directions, as long as `size` (normalised) at most."""
    random, rows = np.random.default_rng(1), []
    while len(rows) < count:
        angle = random.uniform(0.0, 2.0 * math.pi)
        p = size * random.uniform() * np.array([math.cos(angle), math.sin(angle)])
        settings = displaced_settings(run, p)
        if not settings:
            break
        answer, _ = called("adapt", path, *settings, "--out", folder / "adapted.h5")
        rows.append((answer["adaptation"]["outcome"], answer["adaptation"]["seconds"]) if answer else ("refused", 0.0))
    return rows


def draw(axes, run, scene, p, title):
    """Safe set and motions, the obstacle displaced by p."""
    data = run.data
    low, high = data.to_data(run.problem.workspace_lower), data.to_data(run.problem.workspace_upper)
    x, y = (np.linspace(low[i], high[i], 221) for i in range(2))
    places = np.stack(np.meshgrid(x, y), axis=-1)
    flat = places.reshape(-1, 2)
    barrier, v = (values.reshape(221, 221, -1) for values in (scene.barrier(flat, p), scene.velocity(flat, p)))
    axes.contourf(x, y, barrier[..., 0], levels=[-1e9, 0], colors=["#d2f5d2"])
    axes.contour(x, y, barrier[..., 0], levels=[0], colors=["#0a7d0a"], linewidths=1)
    axes.streamplot(x, y, v[..., 0], v[..., 1], color="#c4c4c4", density=0.7, linewidth=0.5, arrowsize=0.6)
    for radius, style in ((scene.inner, "-"), (scene.outer, ":")):
        axes.add_patch(plt.Circle(scene.center, radius, fill=False, color="#888888", linestyle=style, linewidth=0.9))
    grid = run.in_data_unit().grid
    axes.contourf(grid.axes[0] + p[0], grid.axes[1] + p[1], grid.unsafe.T, levels=[-1e9, 0], colors=["#f2a09a"])
    for k, shown in enumerate(data.demonstrations):
        if k in data.train:
            axes.plot(*shown.position.T, color="#7fb2f5", linewidth=1)
            axes.plot(*follow(scene, shown.position[0], p, data).T, color="#e3128b", linewidth=1)
    axes.plot(*data.goal, marker="*", color="#ffc400", markeredgecolor="#222222", markersize=9)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_title(title, fontsize=9)


def follow(scene, start, p, data):
    """The motion from a start, by the classical Runge-Kutta method."""
    x, path, h = np.array(start, dtype=float), [np.array(start, dtype=float)], 0.02 * data.time_scale
    for _ in range(1500):
        a = scene.velocity(x, p)
        b = scene.velocity(x + 0.5 * h * a, p)
        c = scene.velocity(x + 0.5 * h * b, p)
        x = x + h / 6.0 * (a + 2.0 * b + 2.0 * c + scene.velocity(x + h * c, p))
        path.append(x)
        if np.linalg.norm(x - data.goal) < 0.01 * data.position_scale:
            break
    return np.array(path)


def figure(path, out):
    run = Run(path)
    scene = run.scene_range(program=str(PROGRAM))
    directions = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)]
    shown, panels = plt.subplots(1, 5, figsize=(17, 3.8))
    for axes, direction in zip(panels, directions):
        p = 0.999 * scene.radius * np.array(direction)
        draw(axes, run, scene, p, f"displaced by ({p[0]:.1f}, {p[1]:.1f}) {run.data.unit}")
    shown.tight_layout()
    shown.savefig(out, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", required=True, help="folder of the LASA data")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder of runs and figure")
    parser.add_argument("--adapt", type=int, default=4, help="displacements of each ball or box that adapt is tried on")
    parser.add_argument("--write", action="store_true", help="write the results file of the page")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows, tries = [], []
    for name in MOTIONS:
        path = arguments.out / f"{name}.h5"
        if not path.exists():
            called("train", ROOT / f"experiments/configs/lasa/{name}.toml", "--data", arguments.data, "--seed", 0, "--threads", 1,
                   "--until", "certified", "--out", path)
        answer, complaint = called("range", path)
        if answer is None:
            print(complaint)
            rows.append([name, "none", *["-"] * 7])
            continue
        found, run = answer["range"], Run(path)
        deviation, share = found["deviation"], found["radius"] / found["inner"]
        size = found["inner"] / run.data.position_scale
        here = adapted(path, run, size, arguments.adapt, arguments.out)
        tries += here
        words = ", ".join(f"{sum(o == w for o, _ in here)} {w}" for w in ("held", "adapted", "anew", "failed", "refused")
                          if any(o == w for o, _ in here))
        rows.append([name, f"{math.floor(100 * found['radius']) / 100:.2f}", f"{math.floor(100 * share) / 100:.2f}", f"{min(1.0, math.floor(100 * share) / 100):.2f}",
                     f"{deviation['mean_before']:.2f}", f"{deviation['mean']:.2f}", f"{deviation['largest_before']:.1f}",
                     f"{deviation['largest']:.1f}", words or "-"])
        print(rows[-1], flush=True)
    if tries:
        done = [s for o, s in tries if o in ("held", "adapted", "anew")]
        print(f"adapt: {len(tries)} scenes, median {statistics.median(done):.2f} s where it ends certified")
    figure(arguments.out / "Sine.h5", arguments.out / "displaced_obstacle.png")
    head = ["motion", "range [mm]", "range / radius", "covered", "mean before [mm]", "mean at the ends", "largest before",
            "largest at the ends", "adapt"]
    table = {"experiment": "displaced_obstacle", "tables": {"ranges": {"head": head, "rows": rows}}}
    if arguments.write:
        target = ROOT / "experiments/results/displaced_obstacle.json"
        target.write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()
