#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The README's picture: the phase portrait of a certified run, with its certificate line.

    readme_picture.py --program build/release/experiments/s2nnds [--out phase_portrait.png]
    readme_picture.py --run RUN.h5 [--out phase_portrait.png]

Without a run file the program trains experiments/configs/handwriting/Sine.toml first, which needs no data from elsewhere.
Prints the path it wrote; exit code 2 and one line on stderr when something cannot be used.
"""

import argparse
import os
import subprocess
import sys
import tempfile

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch
from PIL import Image

from s2nnds.plot_run import (
    GOAL,
    INITIAL_EDGE,
    ROLLOUT,
    SAFE_EDGE,
    STYLE,
    TRAIN,
    UNSAFE_EDGE,
    UNSAFE_FILL,
    draw_flow,
    draw_goal,
    draw_lines,
    frame,
    line,
    mark,
    save,
    with_grid,
)
from s2nnds.run import Run, RunError

HERE = os.path.dirname(os.path.abspath(__file__))
CONFIG = os.path.join(HERE, "../experiments/configs/handwriting/Sine.toml")
INSIDE, STREAM = "#ddf2da", "#93ab9b"


def train(program, folder):
    path = os.path.join(folder, "Sine.h5")
    done = subprocess.run([program, "train", CONFIG, "--seed", "0", "--out", path], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RunError(f"{program}: no certified run: {(done.stderr.strip().splitlines() or ['no message'])[-1]}")
    return path


def certificate_line(run):
    """What is proved, in words, and the certificate's key figures."""
    margin = f"{run.certificate['disturbance_margin'] * run.data.velocity_scale:.2g} {run.data.unit}/s"
    return (
        "Proved for every point of the green set: the motion never leaves it, never touches the obstacle,\n"
        f"and converges to the goal. A disturbance of up to {margin} cannot push it out.\n"
        f"guarantee: {run.guarantee}   |   disturbance margin: {margin}   |   weights: {run.certificate['weight_hash'][:12]}"
    )


def draw(run):
    run = with_grid(run)
    x, y = run.grid.axes
    unsafe, initial = run.grid.unsafe.T, run.grid.initial.T
    u, v = (np.linspace(axis[0], axis[-1], 601) for axis in (x, y))  # finer than the grid: narrow gaps stay whole
    barrier = run.B(run.data.to_normalized(np.stack(np.meshgrid(u, v), -1).reshape(-1, 2))).reshape(601, 601)
    figure = plt.figure(figsize=(8.0, 6.6))
    ax = figure.add_axes([0.085, 0.215, 0.625, 0.7576])
    ax.contourf(u, v, barrier, levels=[-np.inf, 0.0], colors=[INSIDE], zorder=0)
    draw_flow(ax, x, y, run.grid.velocity, color=STREAM, linewidth=0.7, density=1.25)
    ax.contour(u, v, barrier, levels=[0.0], colors=[SAFE_EDGE], linewidths=2.2, zorder=4)
    ax.contourf(x, y, unsafe, levels=[-np.inf, 0.0], colors=[UNSAFE_FILL], zorder=3)
    ax.contour(x, y, unsafe, levels=[0.0], colors=[UNSAFE_EDGE], linewidths=1.6, zorder=4)
    ax.contour(x, y, initial, levels=[0.0], colors=[INITIAL_EDGE], linewidths=1.5, linestyles=["--"], zorder=7)
    draw_lines(ax, [d.position for d in run.data.demonstrations], 0, 1, colors=TRAIN, linewidths=2.6, alpha=0.45, zorder=5)
    rollouts = [rollout.position for rollout in run.rollouts if rollout.start_kind != "grid"]
    draw_lines(ax, rollouts, 0, 1, colors=ROLLOUT, linewidths=1.4, zorder=6)
    draw_goal(ax, run)
    frame(ax, run)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    handles = [
        line("demonstrations", TRAIN, 2.6, alpha=0.45),
        line("learned motion", ROLLOUT, 1.6),
        line("its flow everywhere", STREAM, 1.2),
        Patch(facecolor=INSIDE, edgecolor=SAFE_EDGE, linewidth=2.0, label="certified safe set"),
        Patch(facecolor=UNSAFE_FILL, edgecolor=UNSAFE_EDGE, linewidth=1.4, label="obstacle"),
        line("start set", INITIAL_EDGE, 1.5, linestyle="--"),
        mark("goal", "*", GOAL, "black", 14),
    ]
    figure.legend(
        handles=handles, loc="center left", bbox_to_anchor=(0.735, 0.594), frameon=False, fontsize=11, labelspacing=1.1
    )
    figure.text(0.085, 0.118, certificate_line(run), fontsize=10, va="top", linespacing=1.5)
    return figure


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--run", help="run file to draw; without it --program trains one")
    parser.add_argument("--program", help="the program s2nnds")
    parser.add_argument("--out", default=os.path.join(HERE, "phase_portrait.png"))
    options = parser.parse_args(arguments)
    if not (options.run or options.program):
        parser.error("expected --run or --program")
    try:
        with tempfile.TemporaryDirectory() as folder, plt.rc_context({**STYLE, "savefig.dpi": 125}):
            run = Run(options.run or train(options.program, folder))
            if run.dimension != 2:
                raise RunError(f"{run.path}: found dimension {run.dimension}, expected 2")
            if run.guarantee != "invariant":
                raise RunError(f"{run.path}: found guarantee {run.guarantee}, expected invariant")
            save(draw(run), options.out, "png")
            with Image.open(options.out) as picture:  # a palette: a quarter of the size
                small = picture.convert("RGB").quantize(192, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            small.save(options.out, optimize=True)
        print(options.out)
    except (RunError, OSError) as error:
        print(f"readme_picture: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
