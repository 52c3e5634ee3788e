# SPDX-License-Identifier: BSD-3-Clause
"""Figures of what the simulated arm drew: Fig. 2 of the paper with the executed paths in brown.

    python -m s2nnds.plot_drawing ROBOT_DRAWING.json

The file is what experiments/robot_drawing wrote; beside it lies a figure of each run, NAME.png, with a panel for each
controller (row) and kind of start (column). Exit code 2 and one line on stderr when a file cannot be used.
"""

import json
import os
import sys

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Line3DCollection

from .plot_run import (
    SAFE_EDGE,
    STYLE,
    UNSAFE_EDGE,
    demonstration_groups,
    draw_flow,
    draw_goal,
    draw_lines,
    draw_sets,
    draw_surface,
    frame,
    goal_handle,
    has_zero,
    legend_below,
    line,
    save,
    with_grid,
)
from .run import Run, RunError

EXECUTED, LEFT = "#7b4a1e", "#6a1b9a"


def planar_panel(ax, run, paths, left):
    handles = draw_sets(ax, *run.grid.axes, run.grid.unsafe, None, run.grid.B)
    draw_flow(ax, *run.grid.axes, run.grid.velocity, density=0.9)
    for label, colour, positions in demonstration_groups(run):
        draw_lines(ax, positions, 0, 1, colors=colour, linewidths=1.0, alpha=0.6, zorder=5)
        handles.append(line(label, colour, 1.0))
    for path, out in zip(paths, left):
        ax.plot(*path.T, color=LEFT if out else EXECUTED, linewidth=1.1, zorder=6)
        ax.plot(*path[:1].T, ".", color=LEFT if out else EXECUTED, markersize=4, zorder=6)
    draw_goal(ax, run)
    frame(ax, run)
    return handles


def spatial_panel(ax, run, paths, left):
    handles = []
    for level, surface, label in (
        (run.grid.B, ("#4fc04f", 0.10, 1, 26), line("boundary of the safe set", SAFE_EDGE)),
        (run.grid.unsafe, ("#e5534b", 0.75, 3, 60), line("unsafe set", UNSAFE_EDGE)),
    ):
        if has_zero(level):
            draw_surface(ax, run.grid.axes, level, *surface)
            handles.append(label)
    for label, colour, positions in demonstration_groups(run):
        ax.add_collection(Line3DCollection(positions, colors=colour, linewidths=0.9, alpha=0.6, zorder=5))
        handles.append(line(label, colour, 1.0))
    for path, out in zip(paths, left):
        ax.plot(*path.T, color=LEFT if out else EXECUTED, linewidth=1.1, zorder=6)
    lower, upper = run.problem.workspace_lower, run.problem.workspace_upper
    ax.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    ax.set_box_aspect(upper - lower)
    ax.view_init(elev=24, azim=-58)
    return handles


def figure_of(drawn):
    run = with_grid(Run(drawn["file"]))
    controls, scenes = (list(dict.fromkeys(one[key] for one in drawn["motions"])) for key in ("control", "scene"))
    spatial = run.dimension == 3
    figure, axes = plt.subplots(
        len(controls), len(scenes), figsize=(3.5 * len(scenes), 3.6 * len(controls) + 0.5), squeeze=False,
        constrained_layout=True, subplot_kw={"projection": "3d", "computed_zorder": False} if spatial else {},
    )  # fmt: skip
    handles = []
    for i, control in enumerate(controls):
        for j, scene in enumerate(scenes):
            motions = [one for one in drawn["motions"] if (one["control"], one["scene"]) == (control, scene)]
            paths = [np.asarray(one["path"], dtype=float) for one in motions]
            panel = spatial_panel if spatial else planar_panel
            handles = panel(axes[i, j], run, paths, [one["left"] for one in motions])
            axes[i, j].set_title(f"{control}: {scene}", fontsize=10)
    figure.suptitle(f"{run.name}, as a simulated arm draws it", fontsize=12)
    handles += [line("executed", EXECUTED), line("executed, left {B ≤ 0}", LEFT)]
    if not spatial:
        handles.append(goal_handle())
    legend_below(figure, handles, 4)
    return run.name, figure


def main(arguments=None):
    (path,) = arguments if arguments is not None else sys.argv[1:]
    try:
        with open(path, encoding="utf-8") as file:
            found = json.load(file)
        with plt.rc_context(STYLE):
            for drawn in found["motions"]:
                name, figure = figure_of(drawn)
                target = os.path.join(os.path.dirname(path), f"{name}.png")
                save(figure, target, "png")
                plt.close(figure)
                print(target)
    except (RunError, OSError, ValueError, KeyError) as error:
        print(f"plot_drawing: {path}: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
