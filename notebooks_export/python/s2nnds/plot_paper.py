# SPDX-License-Identifier: BSD-3-Clause
"""Figures of several runs in one, as the paper arranges them.

    python -m s2nnds.plot_paper panels FIGURE RUN.h5...
        the phase portraits of planar runs side by side (Fig. 2)
    python -m s2nnds.plot_paper against FIGURE RESULTS.json RUN.h5...
        ours above, ABC-DS's polynomials below (Fig. 4); RESULTS.json is what the driver abc_ds_benchmark wrote, for these runs

FIGURE ends in .png or .pdf. Exit code 2 and one line on stderr when a file cannot be used.
"""

import argparse
import json
import os
import sys

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from .plot_run import (
    ROLLOUT,
    STYLE,
    demonstration_groups,
    draw_flow,
    draw_goal,
    draw_lines,
    draw_phase_portrait,
    draw_sets,
    frame,
    legend_below,
    save,
    with_grid,
)
from .run import Run, RunError


def planar(paths):
    runs = [Run(path) for path in paths]
    for path, run in zip(paths, runs):
        if run.dimension != 2:
            raise RunError(f"{path}: found dimension {run.dimension}, expected 2")
    return runs


def plain_axes(ax):
    """The unit alone: every panel has the same axes."""
    ax.set_xlabel(ax.get_xlabel().partition(" ")[2])
    ax.set_ylabel("")


def grid_of_panels(rows, columns, height):
    figure, axes = plt.subplots(rows, columns, figsize=(3.4 * columns, height), squeeze=False, layout="constrained")
    figure.get_layout_engine().set(h_pad=0.12)  # a row's titles stay off the labels of the row above
    return figure, axes


def panels(runs, columns=4):
    """One phase portrait a run, titled by its motion and guarantee."""
    rows = -(-len(runs) // columns)
    columns = min(columns, len(runs))
    figure, axes = grid_of_panels(rows, columns, 3.7 * rows)
    handles = []
    for ax, run in zip(axes.flat, runs):
        handles += draw_phase_portrait(ax, with_grid(run))
        ax.set_title(f"{run.name}: {run.guarantee}\nsafe set {run.evaluation['safe_area_ratio']:.0%} of the truly safe one")
        plain_axes(ax)
    for ax in axes.flat[len(runs) :]:
        ax.axis("off")
    legend_below(figure, handles, columns=5)
    return figure


class Polynomials:
    """Vector of polynomials in two variables: [{coefficients: [t], exponents: [[a, b]]}, ...]."""

    def __init__(self, parts):
        self.parts = [(np.array(p["coefficients"]), np.array(p["exponents"])) for p in parts]

    def __call__(self, x):
        """x [N, 2] -> [N, parts]."""
        return np.stack(
            [np.prod(x[:, None, :] ** exponents[None], axis=2) @ coefficients for coefficients, exponents in self.parts],
            axis=1,
        )


def follow(f, start, step=0.02, steps=3000):
    """The motion from start [2] by the classical Runge-Kutta method, until it is at the goal or far away."""
    path = [np.asarray(start, float)]
    for _ in range(steps):
        x = path[-1][None]
        k1 = f(x)
        k2 = f(x + 0.5 * step * k1)
        k3 = f(x + 0.5 * step * k2)
        k4 = f(x + step * k3)
        path.append((x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4))[0])
        if np.linalg.norm(path[-1]) < 0.01 or np.abs(path[-1]).max() > 2:
            break
    return np.array(path)


def draw_polynomials(ax, run, published):
    """ABC-DS's flow, {B <= 0} and rollouts on the normalised square [-1, 1]^2, on which its conditions speak."""
    f, barrier = Polynomials(published["f"]), Polynomials(published["B"])
    axis = np.linspace(-1.0, 1.0, 161)
    points = np.stack(np.meshgrid(axis, axis, indexing="ij"), -1).reshape(-1, 2)
    starts = [demonstration.position[0] for demonstration in run.data.normalized]
    rollouts = [run.data.to_data(follow(f, start)) for start in starts]
    x, y = run.data.to_data(np.stack([axis, axis], -1)).T
    run = with_grid(run)
    handles = draw_sets(ax, x, y, barrier=barrier(points)[:, 0].reshape(161, 161))
    handles += draw_sets(ax, *run.grid.axes, unsafe=run.grid.unsafe, initial=run.grid.initial)
    handles += draw_flow(ax, x, y, f(points).reshape(161, 161, 2))
    for _, colour, positions in demonstration_groups(run):
        draw_lines(ax, positions, 0, 1, colors=colour, linewidths=1.4, zorder=5)
    draw_lines(ax, rollouts, 0, 1, colors=ROLLOUT, linewidths=1.6, zorder=6)
    draw_goal(ax, run)
    frame(ax, run)
    return handles


def against(runs, results):
    published = {row["motion"]: row for row in results["abc_ds"]}
    figure, axes = grid_of_panels(2, len(runs), 7.4)
    handles = []
    for ours, theirs, run in zip(axes[0], axes[1], runs):
        motion = run.name.removesuffix("_abc_ds")
        if motion not in published:
            raise RunError(f"found no ABC-DS result for {motion} in the results, expected one")
        row = published[motion]
        handles += draw_phase_portrait(ours, with_grid(run))
        ours.set_title(f"{motion}, ours: {run.guarantee}\ntest MSE {run.evaluation['mse_test']:.3f}")
        handles += draw_polynomials(theirs, run, row)
        theirs.set_title(f"{motion}, ABC-DS\ntest MSE {row['mse_test']:.3f}")
        for ax in (ours, theirs):
            plain_axes(ax)
    legend_below(figure, handles, columns=5)
    return figure


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Figures of several runs in one.")
    parser.add_argument("kind", choices=("panels", "against"))
    parser.add_argument("figure", help="file to write, .png or .pdf")
    parser.add_argument("files", nargs="+", help="run files; for `against`, the results file before them")
    options = parser.parse_args(arguments)
    try:
        with plt.rc_context(STYLE):
            if options.kind == "panels":
                figure = panels(planar(options.files))
            else:
                with open(options.files[0], encoding="utf-8") as file:
                    figure = against(planar(options.files[1:]), json.load(file))
            save(figure, options.figure, os.path.splitext(options.figure)[1][1:] or "png")
        print(options.figure)
    except (RunError, KeyError, ValueError, OSError) as error:
        print(f"plot_paper: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
