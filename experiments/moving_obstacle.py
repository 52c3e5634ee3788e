#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A ball travels across the workspace in 50 steps; the motion is certified anew (`s2nnds adapt`) before each is used.

Writes run files, results.json, moving_obstacle.png and moving_obstacle.gif below --out, and prints a table: how each
certificate was come by, and its seconds against those of a first certificate from scratch in the same scene (every tenth).

    experiments/moving_obstacle.py --out FOLDER [--config experiments/configs/handwriting/Sine.toml] [--steps 50]
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.animation import PillowWriter  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "build/release/python"))
from s2nnds.run import Run  # noqa: E402
PROGRAM = ROOT / "build/release/experiments/s2nnds"


def called(*words):
    """The program's answer as an object, with its exit code."""
    done = subprocess.run([str(PROGRAM), *map(str, words), "--json"], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(done.stderr.strip())
    return {**json.loads(done.stdout.strip().splitlines()[-1]), "code": done.returncode}


def travel(arguments):
    """Yields (step, centre, run file, row) from the first certificate on."""
    start, end = np.array(arguments.start), np.array(arguments.end)
    run = arguments.out / "step-00.h5"
    words = ["--set", f"problem.unsafe.radius={arguments.radius}"]
    first = called("train", arguments.config, "--set", f"problem.unsafe.center={start.tolist()}", *words, "--until",
                   "certified", "--out", run)
    yield 0, start, run, {"outcome": "trained", "seconds": first["seconds"]["training"], "code": first["code"]}
    for step in range(1, arguments.steps):
        centre = start + (end - start) * step / (arguments.steps - 1)
        new = arguments.out / f"step-{step:02}.h5"
        centre_words = ["--set", f"problem.unsafe.center={np.round(centre, 5).tolist()}"]
        found = called("adapt", run, *centre_words, "--out", new)
        row = {**found["adaptation"], "code": found["code"], "guarantee": found["guarantee"], "follows": found["follows"]}
        if step % 10 == 0:
            anew = called("train", arguments.config, *centre_words, *words, "--until", "certified", "--out",
                          arguments.out / "scratch.h5")
            row["scratch"] = anew["seconds"]["training"] if anew["code"] == 0 else None
        if found["guarantee"] == "invariant":
            run = new
        yield step, centre, new, row


def draw(axes, path, row, step):
    run = Run(path)
    grid = run.grid
    axes.clear()
    x, y = grid.axes
    certified = row.get("guarantee", "invariant") == "invariant"
    axes.contourf(x, y, grid.B.T, levels=[-1e9, 0], colors=["#d2f5d2" if certified else "#eeeeee"])
    axes.contour(x, y, grid.B.T, levels=[0], colors=["#0a7d0a"], linewidths=1)
    axes.contourf(x, y, grid.unsafe.T, levels=[-1e9, 0], colors=["#f2a09a"])
    axes.streamplot(x, y, grid.velocity[..., 0].T, grid.velocity[..., 1].T, color="#c4c4c4", density=0.7, linewidth=0.5,
                    arrowsize=0.6)
    demonstrations = run.data.demonstrations
    scale, goal = run.data.position_scale, np.asarray(run.data.goal)
    for shown in demonstrations:
        p = (shown.position - goal) / scale
        axes.plot(p[:, 0], p[:, 1], color="#7fb2f5", linewidth=1)
    for rollout in run.rollouts:
        axes.plot(*np.asarray(rollout.position).T, color="#e3128b", linewidth=1.2)
    axes.plot(0, 0, marker="*", color="#ffc400", markeredgecolor="#222222", markersize=9)
    axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), aspect="equal")
    axes.set_title(f"step {step}: {row['outcome']}, {row['seconds']:.1f} s", fontsize=9)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder of runs, results, figure and film")
    parser.add_argument("--config", default=str(ROOT / "experiments/configs/handwriting/Sine.toml"),
                        help="a problem in two dimensions whose obstacle is a ball, normalised")
    parser.add_argument("--steps", type=int, default=50, help="positions of the ball")
    parser.add_argument("--start", type=float, nargs=2, default=[-0.32, 0.8], help="the ball's first centre")
    parser.add_argument("--end", type=float, nargs=2, default=[-0.32, -0.8], help="the ball's last centre")
    parser.add_argument("--radius", type=float, default=0.12, help="of the ball")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = []
    figure, axes = plt.subplots(figsize=(4.2, 4.2))
    film = PillowWriter(fps=6)
    still, panels = plt.subplots(2, 4, figsize=(13, 6.8))
    chosen = {round(k * (arguments.steps - 1) / 7): k for k in range(8)}
    with film.saving(figure, str(arguments.out / "moving_obstacle.gif"), dpi=90):
        for step, centre, path, row in travel(arguments):
            rows.append({"step": step, "centre": np.round(centre, 4).tolist(), **row})
            print(json.dumps(rows[-1]), flush=True)
            draw(axes, path, row, step)
            film.grab_frame()
            if step in chosen:
                draw(panels.flat[chosen[step]], path, row, step)
    still.tight_layout()
    still.savefig(arguments.out / "moving_obstacle.png", dpi=110)
    (arguments.out / "results.json").write_text(json.dumps(rows, indent=1))
    moved = rows[1:]
    seconds = [row["seconds"] for row in moved]
    scratch = [row["scratch"] for row in moved if row.get("scratch")]
    certified = sum(row["guarantee"] == "invariant" for row in moved)
    print(f"{certified} of {len(moved)} steps certified; " +
          ", ".join(f"{sum(r['outcome'] == o for r in moved)} {o}" for o in ("held", "adapted", "anew", "failed")) +
          f"; median {statistics.median(seconds):.2f} s, longest {max(seconds):.1f} s; first certificate from scratch in "
          f"the same scenes: median {statistics.median(scratch) if scratch else float('nan'):.1f} s")


if __name__ == "__main__":
    main()
