#!/usr/bin/env python3
"""Figures of one run, from its run file alone.

    plot_run.py RUN.h5 --out DIR [--format png|pdf]

2-D: phase_portrait, lyapunov, history. 3-D: the same and slices. More dimensions: pairwise projections.
Prints the paths it wrote; exit code 2 and one line on stderr when the file or the folder cannot be used.
"""

import argparse
import os
import sys
from dataclasses import replace
from itertools import combinations

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.colors import LogNorm, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import LogFormatterSciNotation, MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from isosurface import isosurface
from s2nnds_run import Grid, Run, RunError

SAFE_FILL, SAFE_EDGE = "#d2f5d2", "#0a7d0a"
UNSAFE_FILL, UNSAFE_EDGE = "#f2a09a", "#b3261e"
INITIAL_EDGE = "#222222"
TRAIN, TEST, ROLLOUT = "#1f4fd1", "#7fb2f5", "#e3128b"
FLOW, OPEN_BOX, GOAL = "#9a9a9a", "#f57c00", "#ffc400"

STYLE = {
    "figure.dpi": 150,
    "savefig.dpi": 150,
    "font.size": 10,
    "axes.titlesize": 11,
    "legend.fontsize": 9,
    "axes.labelsize": 10,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "axes.axisbelow": True,
}


# ---------------------------------------------------------------- what the figures are made of


def grid_of(run):
    """The stored grid, or one evaluated here from the networks (then without the sets); None beyond 3-D."""
    n = run.dimension
    if n > 3:
        return None
    if run.grid is None:
        count = 161 if n == 2 else 31
        axes = [
            np.linspace(low, high, count)
            for low, high in zip(run.problem.workspace_lower, run.problem.workspace_upper)
        ]
        grid = Grid(axes)
    else:
        grid = replace(run.grid)
    shape = tuple(len(axis) for axis in grid.axes)
    points = np.stack(np.meshgrid(*grid.axes, indexing="ij"), -1).reshape(-1, n)
    for name in ("V", "B"):
        if getattr(grid, name) is None:
            setattr(grid, name, getattr(run, name)(points).reshape(shape))
    if grid.velocity is None:
        grid.velocity = run.f(points).reshape(shape + (n,))
    return grid


def title_of(run):
    lines = [f"{run.name or 'run'}: guarantee {run.guarantee}"]
    size = "area" if run.dimension == 2 else "volume"
    facts = [
        f"{label} {run.evaluation[key]:.3g}"
        for key, label in (
            ("mse_test", "test MSE"),
            ("safe_area", f"safe {size}"),
            ("true_safe_area", f"true safe {size}"),
        )
        if np.isfinite(run.evaluation.get(key, np.nan))
    ]
    if facts:
        lines.append(", ".join(facts))
    return "\n".join(lines)


def axis_label(run, k):
    """x_k with the length that 1 stands for."""
    unit = f" / {run.data.position_scale:.3g} {run.data.unit}" if run.data.unit else " (normalised)"
    return f"$x_{k + 1}${unit}"


def demonstration_groups(run):
    """(label, colour, positions of the demonstrations) of the train and the test demonstrations."""
    groups = []
    for label, colour, indices in (
        ("demonstrations", TRAIN, run.data.train),
        ("test demonstrations", TEST, run.data.test),
    ):
        if indices:
            groups.append((label, colour, [run.data.demonstrations[k].position for k in indices]))
    return groups


def rollout_groups(run):
    """(label, line width, opacity, positions): from the demonstrations' starts, and from a grid's."""
    own = [rollout.position for rollout in run.rollouts if rollout.start_kind != "grid"]
    grid = [rollout.position for rollout in run.rollouts if rollout.start_kind == "grid"]
    return [
        group
        for group in (("rollouts from the grid", 0.7, 0.55, grid), ("rollouts", 1.6, 1.0, own))
        if group[3]
    ]


def failed_ends(run):
    """Last points of rollouts that met the unsafe set or left the workspace: [k, n]."""
    ends = [
        rollout.position[-1]
        for rollout in run.rollouts
        if rollout.stop in ("entered_unsafe", "left_workspace") and len(rollout.position)
    ]
    return np.array(ends).reshape(-1, run.dimension)


def all_open_boxes(run):
    boxes = [array for array in run.open_boxes.values() if len(array)]
    return np.concatenate(boxes) if boxes else np.zeros((0, 2 * run.dimension))


def reaches(level):
    """Some sample lies in {level <= 0}; NaN does not."""
    return level is not None and bool((level <= 0.0).any())


def has_zero(level):
    return reaches(level) and bool((level > 0.0).any())


# ---------------------------------------------------------------- drawing in a plane


def goal_handle():
    return Line2D(
        [],
        [],
        marker="*",
        color="none",
        markerfacecolor=GOAL,
        markeredgecolor="black",
        markersize=13,
        label="goal",
    )


def draw_goal(ax, x=0.0, y=0.0):
    ax.plot(
        [x],
        [y],
        marker="*",
        color=GOAL,
        markeredgecolor="black",
        markeredgewidth=0.8,
        markersize=14,
        zorder=9,
    )


def draw_sets(ax, x, y, unsafe=None, initial=None, barrier=None):
    """The safe set, the unsafe set and X0 from their samples [len(x), len(y)]; returns legend handles."""
    handles = []
    if reaches(barrier):
        ax.contourf(x, y, barrier.T, levels=[-np.inf, 0.0], colors=[SAFE_FILL], zorder=0)
        if has_zero(barrier):
            ax.contour(x, y, barrier.T, levels=[0.0], colors=[SAFE_EDGE], linewidths=1.8, zorder=4)
        handles.append(
            Patch(facecolor=SAFE_FILL, edgecolor=SAFE_EDGE, linewidth=1.8, label="safe set {B ≤ 0}")
        )
    if reaches(unsafe):
        ax.contourf(x, y, unsafe.T, levels=[-np.inf, 0.0], colors=[UNSAFE_FILL], zorder=3)
        if has_zero(unsafe):
            ax.contour(x, y, unsafe.T, levels=[0.0], colors=[UNSAFE_EDGE], linewidths=1.2, zorder=4)
        handles.append(Patch(facecolor=UNSAFE_FILL, edgecolor=UNSAFE_EDGE, label="unsafe set"))
    if has_zero(initial):
        ax.contour(
            x, y, initial.T, levels=[0.0], colors=[INITIAL_EDGE], linewidths=1.4, linestyles=["--"], zorder=7
        )
        handles.append(Line2D([], [], color=INITIAL_EDGE, linestyle="--", linewidth=1.4, label="initial set"))
    return handles


def draw_rollouts(ax, run, i, j, fade):
    handles = []
    for label, width, alpha, positions in rollout_groups(run):
        ax.add_collection(
            LineCollection(
                [p[:, [i, j]] for p in positions],
                colors=ROLLOUT,
                linewidths=width,
                alpha=alpha * fade,
                zorder=6,
            ),
            autolim=False,
        )
        handles.append(Line2D([], [], color=ROLLOUT, linewidth=width, alpha=alpha, label=label))
    return handles


def draw_motions(ax, run, i=0, j=1, faint=False):
    """Demonstrations and rollouts, projected on the plane of axes i and j; returns legend handles."""
    handles = []
    fade = 0.45 if faint else 1.0
    for label, colour, positions in demonstration_groups(run):
        ax.add_collection(
            LineCollection(
                [p[:, [i, j]] for p in positions], colors=colour, linewidths=1.4, alpha=0.9 * fade, zorder=5
            ),
            autolim=False,
        )
        handles.append(Line2D([], [], color=colour, linewidth=1.6, label=label))
    handles += draw_rollouts(ax, run, i, j, fade)
    ends = failed_ends(run)
    if len(ends) and not faint:
        ax.plot(ends[:, i], ends[:, j], "x", color="black", markersize=6, markeredgewidth=1.6, zorder=8)
        handles.append(
            Line2D(
                [],
                [],
                marker="x",
                color="none",
                markeredgecolor="black",
                markersize=6,
                markeredgewidth=1.6,
                label="rollout stopped: unsafe or left",
            )
        )
    return handles


def draw_boxes(ax, boxes, i=0, j=1):
    """Boxes [k, 2n] that a proof left open; edges have a width of their own, so that tiny ones are seen."""
    if not len(boxes):
        return []
    n = boxes.shape[1] // 2
    patches = [Rectangle((box[i], box[j]), box[n + i] - box[i], box[n + j] - box[j]) for box in boxes]
    ax.add_collection(
        PatchCollection(patches, facecolor=OPEN_BOX, edgecolor=OPEN_BOX, linewidths=1.2, zorder=7.5),
        autolim=False,
    )
    return [Patch(facecolor=OPEN_BOX, edgecolor=OPEN_BOX, label="open boxes of the proof")]


def frame(ax, run, i=0, j=1):
    """Equal axes over the workspace, with the containment box where there is one."""
    lower, upper = run.problem.workspace_lower, run.problem.workspace_upper
    share = run.problem.containment
    if 0.0 < share < 1.0:
        middle, half = 0.5 * (lower + upper), 0.5 * share * (upper - lower)
        ax.add_patch(
            Rectangle(
                (middle - half)[[i, j]],
                2 * half[i],
                2 * half[j],
                fill=False,
                edgecolor="#666666",
                linewidth=0.8,
                linestyle=":",
                zorder=2,
            )
        )
    ax.set_xlim(lower[i], upper[i])
    ax.set_ylim(lower[j], upper[j])
    ax.set_aspect("equal")
    ax.set_xlabel(axis_label(run, i))
    ax.set_ylabel(axis_label(run, j))


def legend_below(figure, handles, columns=3):
    """One legend under all axes, each label once."""
    unique = list({handle.get_label(): handle for handle in handles}.values())
    figure.legend(
        handles=unique,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        ncol=min(columns, len(unique)),
        frameon=False,
        handlelength=1.8,
        columnspacing=1.6,
    )


# ---------------------------------------------------------------- phase portrait


def draw_flow(ax, x, y, velocity):
    """Streamlines of samples [len(x), len(y), 2]; streamplot wants spacings equal to the last bit."""
    ax.streamplot(
        np.linspace(x[0], x[-1], len(x)),
        np.linspace(y[0], y[-1], len(y)),
        velocity[..., 0].T,
        velocity[..., 1].T,
        color=FLOW,
        density=1.5,
        linewidth=0.6,
        arrowsize=0.8,
        zorder=1,
    )
    return [Line2D([], [], color=FLOW, linewidth=1.0, label="flow of f")]


def draw_phase_portrait(ax, run, grid):
    """All that Fig. 2 of the paper shows of a planar run; returns legend handles."""
    x, y = grid.axes
    handles = draw_sets(ax, x, y, grid.unsafe, grid.initial, grid.B)
    flow = draw_flow(ax, x, y, grid.velocity)
    handles += draw_motions(ax, run)
    handles += draw_boxes(ax, all_open_boxes(run))
    draw_goal(ax)
    frame(ax, run)
    return handles + [goal_handle()] + flow


def phase_portrait_2d(run, grid):
    figure, ax = plt.subplots(figsize=(6.2, 6.2), constrained_layout=True)
    handles = draw_phase_portrait(ax, run, grid)
    ax.set_title(title_of(run))
    legend_below(figure, handles)
    return figure


def thinned(axes, level, most):
    """Every k-th sample, so that a drawn surface has some ten thousand triangles at most."""
    steps = [max(1, int(np.ceil((len(axis) - 1) / (most - 1)))) for axis in axes]
    picks = [
        np.unique(np.append(np.arange(0, len(axis), step), len(axis) - 1)) for axis, step in zip(axes, steps)
    ]
    return [axis[pick] for axis, pick in zip(axes, picks)], level[np.ix_(*picks)]


def draw_surface(ax, axes, level, colour, alpha, zorder, most=26):
    """The boundary of {level <= 0}, lit from one side whatever the triangles' orientation."""
    triangles = isosurface(*thinned(axes, level, most))
    if not len(triangles):
        return
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    light = np.array([0.45, -0.35, 0.82])
    shade = 0.55 + 0.45 * np.abs(normals @ light)
    colours = np.column_stack([np.outer(shade, to_rgb(colour)), np.full(len(shade), alpha)])
    ax.add_collection3d(
        Poly3DCollection(
            triangles,
            facecolors=colours,
            edgecolors="none",
            linewidths=0,
            antialiaseds=False,
            rasterized=True,
            zorder=zorder,
        )
    )


def phase_portrait_3d(run, grid):
    figure = plt.figure(figsize=(7.0, 6.6))
    ax = figure.add_axes([0.02, 0.04, 0.92, 0.88], projection="3d", computed_zorder=False)
    handles = []
    if has_zero(grid.B):
        draw_surface(ax, grid.axes, grid.B, "#4fc04f", 0.10, 1)
        handles.append(Patch(facecolor=SAFE_FILL, edgecolor=SAFE_EDGE, label="boundary of the safe set"))
    if has_zero(grid.unsafe):
        draw_surface(ax, grid.axes, grid.unsafe, "#e5534b", 0.75, 3, most=60)
        handles.append(Patch(facecolor=UNSAFE_FILL, edgecolor=UNSAFE_EDGE, label="unsafe set"))
    if has_zero(grid.initial):
        draw_surface(ax, grid.axes, grid.initial, "#555555", 0.25, 4, most=60)
        handles.append(Patch(facecolor="#bbbbbb", edgecolor="#555555", label="initial set"))
    for label, colour, positions in demonstration_groups(run):
        ax.add_collection3d(Line3DCollection(positions, colors=colour, linewidths=1.3, zorder=5))
        handles.append(Line2D([], [], color=colour, linewidth=1.6, label=label))
    for label, width, alpha, positions in rollout_groups(run):
        ax.add_collection3d(
            Line3DCollection(positions, colors=ROLLOUT, linewidths=width, alpha=alpha, zorder=6)
        )
        handles.append(Line2D([], [], color=ROLLOUT, linewidth=width, alpha=alpha, label=label))
    ends = failed_ends(run)
    if len(ends):
        ax.plot(*ends.T, "x", color="black", zorder=8)
        handles.append(
            Line2D(
                [],
                [],
                marker="x",
                color="none",
                markeredgecolor="black",
                label="rollout stopped: unsafe or left",
            )
        )
    boxes = all_open_boxes(run)
    if len(boxes):
        centres = 0.5 * (boxes[:, :3] + boxes[:, 3:])
        ax.plot(*centres.T, "s", color=OPEN_BOX, markersize=3, zorder=7)
        handles.append(
            Line2D(
                [],
                [],
                marker="s",
                color="none",
                markerfacecolor=OPEN_BOX,
                markeredgecolor=OPEN_BOX,
                markersize=4,
                label="open boxes of the proof (centres)",
            )
        )
    ax.plot([0], [0], [0], marker="*", color=GOAL, markeredgecolor="black", markersize=15, zorder=9)
    handles.append(goal_handle())
    lower, upper = run.problem.workspace_lower, run.problem.workspace_upper
    ax.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    ax.set_box_aspect(upper - lower, zoom=0.92)  # room for the labels
    ax.set_xlabel(axis_label(run, 0))
    ax.set_ylabel(axis_label(run, 1))
    ax.set_zlabel(axis_label(run, 2))
    ax.view_init(elev=24, azim=-58)
    figure.suptitle(title_of(run), fontsize=11, y=0.93)
    legend_below(figure, handles)
    return figure


def projections(run):
    """Trajectories of a motion in more than three dimensions, on every pair of axes."""
    pairs = list(combinations(range(run.dimension), 2))
    columns = min(3, len(pairs))
    rows = -(-len(pairs) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(3.2 * columns, 3.1 * rows), squeeze=False, constrained_layout=True
    )
    handles = []
    for ax, (i, j) in zip(axes.flat, pairs):
        handles = draw_motions(ax, run, i, j) + draw_boxes(ax, all_open_boxes(run), i, j)
        draw_goal(ax)
        frame(ax, run, i, j)
    for ax in axes.flat[len(pairs) :]:
        ax.axis("off")
    figure.suptitle(title_of(run) + "\nprojections of the trajectories", fontsize=11)
    legend_below(figure, handles + [goal_handle()])
    return figure


# ---------------------------------------------------------------- slices of a 3-D run


def nearest(axis, value):
    return int(np.argmin(np.abs(axis - value)))


def slices(run, grid):
    """Planes through the goal and, where there is an obstacle, through its deepest point."""
    centres = [("goal", np.zeros(3))]
    if reaches(grid.unsafe):
        deepest = np.unravel_index(np.nanargmin(grid.unsafe), grid.unsafe.shape)
        centres.append(("obstacle", np.array([axis[k] for axis, k in zip(grid.axes, deepest)])))
    figure, axes = plt.subplots(
        len(centres), 3, figsize=(10.5, 3.7 * len(centres) + 0.4), squeeze=False, constrained_layout=True
    )
    handles = []
    for row, (name, centre) in zip(axes, centres):
        for ax, fixed in zip(row, (2, 1, 0)):
            index = nearest(grid.axes[fixed], centre[fixed])
            handles += draw_slice(ax, run, grid, fixed, index)
            ax.set_title(f"through the {name}: $x_{fixed + 1}$ = {grid.axes[fixed][index]:.2f}", fontsize=10)
    figure.suptitle(
        title_of(run) + "\n(demonstrations and rollouts are projected on the planes)", fontsize=11
    )
    legend_below(figure, handles + [goal_handle()], columns=4)
    return figure


def draw_slice(ax, run, grid, fixed, index):
    """The plane where axis `fixed` has its value of number `index`."""
    i, j = (k for k in range(3) if k != fixed)
    value = grid.axes[fixed][index]
    cut = {
        name: None if getattr(grid, name) is None else np.take(getattr(grid, name), index, axis=fixed)
        for name in ("unsafe", "initial", "B")
    }
    x, y = grid.axes[i], grid.axes[j]
    handles = draw_sets(ax, x, y, cut["unsafe"], cut["initial"], cut["B"])
    velocity = np.take(grid.velocity, index, axis=fixed)
    step = max(1, len(x) // 14)
    u, v = velocity[::step, ::step, i].T, velocity[::step, ::step, j].T
    length = np.maximum(np.hypot(u, v), 1e-12)
    # the direction matters here, the speed does not: square roots keep slow arrows visible
    ax.quiver(
        x[::step], y[::step], u / np.sqrt(length), v / np.sqrt(length), color=FLOW, width=0.004, zorder=1
    )
    handles += [Line2D([], [], color=FLOW, linewidth=1.0, label="flow of f, in the plane")]
    handles += draw_motions(ax, run, i, j, faint=True)
    boxes = all_open_boxes(run)
    meets = (boxes[:, fixed] <= value) & (value <= boxes[:, 3 + fixed])
    handles += draw_boxes(ax, boxes[meets], i, j)
    draw_goal(ax)
    frame(ax, run, i, j)
    return handles


# ---------------------------------------------------------------- Lyapunov function


def draw_levels(ax, x, y, V, norm, levels):
    """V [len(x), len(y)] in colours and level sets; where V <= 0 the condition fails: grey."""
    mesh = ax.pcolormesh(
        x, y, np.fmax(V, norm.vmin).T, norm=norm, cmap="YlGnBu", shading="gouraud", rasterized=True, zorder=0
    )
    ax.contour(x, y, V.T, levels=levels, colors="#30506a", linewidths=0.7, zorder=1)
    handles = [Line2D([], [], color="#30506a", linewidth=0.9, label="level sets of V")]
    if (V < 0.0).any():
        ax.contourf(x, y, V.T, levels=[-np.inf, 0.0], colors=["#8a8a8a"], zorder=0)
        handles.append(Patch(facecolor="#8a8a8a", label="V ≤ 0"))
    return mesh, handles


def log_levels(V, count=12):
    """A logarithmic scale over the positive values, from a thousandth of the largest on, and levels on it."""
    positive = V[np.isfinite(V) & (V > 0.0)]
    if not len(positive):
        return None, []
    high = positive.max()
    low = max(positive.min(), 1e-3 * high)
    if not low < high:
        low = 0.5 * high
    return LogNorm(low, high, clip=True), np.geomspace(low, high, count + 1)[:-1]


def lyapunov_in_planes(run, grid, planes, figsize):
    """One panel per plane: (fixed axis or None, V [., .], unsafe, B, i, j)."""
    norm, levels = log_levels(np.concatenate([plane[1].ravel() for plane in planes]))
    if norm is None:
        return lyapunov_along_rollouts(run)
    figure, axes = plt.subplots(1, len(planes), figsize=figsize, squeeze=False, constrained_layout=True)
    handles = []
    for ax, (fixed, V, unsafe, barrier, i, j) in zip(axes.flat, planes):
        x, y = grid.axes[i], grid.axes[j]
        fade = 1.0 if fixed is None else 0.6  # projected, not cut
        mesh, more = draw_levels(ax, x, y, V, norm, levels)
        handles += more
        if has_zero(barrier):
            ax.contour(x, y, barrier.T, levels=[0.0], colors=[SAFE_EDGE], linewidths=1.8, zorder=4)
            handles.append(Line2D([], [], color=SAFE_EDGE, linewidth=1.8, label="boundary of the safe set"))
        handles += draw_sets(ax, x, y, unsafe)
        handles += draw_rollouts(ax, run, i, j, fade)
        draw_goal(ax)
        frame(ax, run, i, j)
        if fixed is not None:
            ax.set_title(
                f"$x_{fixed + 1}$ = {grid.axes[fixed][nearest(grid.axes[fixed], 0.0)]:.2f}", fontsize=10
            )
    figure.suptitle(f"{run.name or 'run'}: Lyapunov function", fontsize=11)
    figure.colorbar(mesh, ax=axes, label="V", shrink=0.85, pad=0.02, extend="min")
    legend_below(figure, handles + [goal_handle()], columns=4 if len(planes) > 1 else 3)
    return figure


def lyapunov_along_rollouts(run):
    figure, ax = plt.subplots(figsize=(6.4, 4.2), constrained_layout=True)
    handles = []
    motions = [(ROLLOUT, 1.0, "rollouts", rollout.time, rollout.position) for rollout in run.rollouts]
    scale = run.data.velocity_scale / run.data.position_scale
    motions += [
        (TRAIN, 0.6, "demonstrations", demonstration.time * scale, demonstration.position)
        for demonstration in run.data.demonstrations
    ]
    for colour, width, label, time, position in motions:
        ax.plot(time, run.V(position), color=colour, linewidth=width)
        handles.append(Line2D([], [], color=colour, linewidth=width + 0.6, label=label))
    ax.set_yscale("log")
    low, high = ax.get_ylim()
    ax.set_ylim(max(low, 1e-7 * high), high)  # V = 0 at the goal would stretch the axis without end
    ax.set_xlabel("time (normalised)")
    ax.set_ylabel("V")
    ax.grid(alpha=0.3)
    ax.set_title(f"{run.name or 'run'}: Lyapunov function along the motions")
    if handles:
        legend_below(figure, handles)
    return figure


def lyapunov(run, grid):
    if grid is None:
        return lyapunov_along_rollouts(run)
    if run.dimension == 2:
        return lyapunov_in_planes(run, grid, [(None, grid.V, grid.unsafe, grid.B, 0, 1)], (6.8, 5.8))
    planes = []
    for fixed in (2, 1, 0):
        i, j = (k for k in range(3) if k != fixed)
        index = nearest(grid.axes[fixed], 0.0)
        cuts = [
            None if level is None else np.take(level, index, axis=fixed)
            for level in (grid.V, grid.unsafe, grid.B)
        ]
        planes.append((fixed, *cuts, i, j))
    return lyapunov_in_planes(run, grid, planes, (11.5, 4.2))


# ---------------------------------------------------------------- history


def history_panels(history):
    """[(title, columns, scale)] of numeric columns, by what their names say."""
    numeric = {
        name: np.asarray(column, dtype=float)
        for name, column in history.items()
        if np.asarray(column).dtype.kind in "bfiu" and np.isfinite(np.asarray(column, dtype=float)).any()
    }
    numeric.pop("round", None)
    kinds = {"losses": {}, "counterexamples": {}, "seconds": {}, "other figures": {}}
    for name, column in numeric.items():
        if name.startswith("count") or "violation" in name or "counterexample" in name:
            kinds["counterexamples"][name.removeprefix("count_").replace("_", " ")] = column
        elif "second" in name:
            kinds["seconds"][name.removeprefix("seconds_").replace("_", " ")] = column
        elif any(word in name for word in ("loss", "mse", "term")):
            kinds["losses"][name.replace("_", " ")] = column
        else:
            kinds["other figures"][name.replace("_", " ")] = column
    return [(title, columns) for title, columns in kinds.items() if columns]


def draw_columns(ax, rounds, title, columns):
    colours = plt.get_cmap("tab10").colors
    for k, (name, column) in enumerate(columns.items()):
        ax.plot(
            rounds,
            column,
            marker="o",
            markersize=3.5,
            linewidth=1.3,
            color=colours[k % 10],
            linestyle=("-", "--", ":")[k // 10 % 3],
            label=name,
        )
    finite = np.concatenate([column[np.isfinite(column)] for column in columns.values()])
    if title == "losses" and (finite > 0.0).all():
        ax.set_yscale("log")
        ax.yaxis.set_minor_formatter(LogFormatterSciNotation(labelOnlyBase=False, minor_thresholds=(2, 0.5)))
    elif title in ("counterexamples", "other figures") and finite.max() > 100.0:
        ax.set_yscale("symlog", linthresh=1.0)  # zero is the aim, so it must be on the axis
    if title in ("counterexamples", "seconds") and finite.min() >= 0.0:
        ax.set_ylim(bottom=0.0)
    if title == "counterexamples" and ax.get_yscale() == "linear":
        ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_title(title, fontsize=10)
    ax.set_xlabel("round")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    if len(rounds) == 1:
        ax.set_xlim(rounds[0] - 1, rounds[0] + 1)
    ax.grid(alpha=0.3)
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, borderaxespad=0.0)


def history(run):
    panels = history_panels(run.history)
    if not panels:
        return None
    figure, axes = plt.subplots(
        len(panels), 1, figsize=(7.2, 2.5 * len(panels) + 0.4), squeeze=False, constrained_layout=True
    )
    for ax, (title, columns) in zip(axes.flat, panels):
        count = len(next(iter(columns.values())))
        draw_columns(ax, np.asarray(run.history.get("round", np.arange(1, count + 1))), title, columns)
    figure.suptitle(f"{run.name or 'run'}: training history", fontsize=11)
    return figure


# ---------------------------------------------------------------- the program


def make_figures(run):
    """name -> figure; what the run has no data for is left out."""
    grid = grid_of(run)
    if run.dimension == 2:
        yield "phase_portrait", phase_portrait_2d(run, grid)
    elif run.dimension == 3:
        yield "phase_portrait", phase_portrait_3d(run, grid)
        yield "slices", slices(run, grid)
    else:
        yield "phase_portrait", projections(run)
    yield "lyapunov", lyapunov(run, grid)
    figure = history(run)
    if figure is not None:
        yield "history", figure


def save(figure, path, kind):
    """Written beside its place and renamed, so that a crash leaves no half figure; no time stamp inside."""
    metadata = {"CreationDate": None} if kind == "pdf" else {"Software": None}
    part = f"{path}.part"
    figure.savefig(part, format=kind, bbox_inches="tight", pad_inches=0.08, metadata=metadata)
    os.replace(part, path)


def plot(run_path, out, kind="png"):
    """Writes the figures of a run file into the folder `out`, yields their paths."""
    run = Run(run_path)
    os.makedirs(out, exist_ok=True)
    with plt.rc_context(STYLE):
        for name, figure in make_figures(run):
            path = os.path.join(out, f"{name}.{kind}")
            save(figure, path, kind)
            plt.close(figure)
            yield path


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Figures of one run, from its run file alone.")
    parser.add_argument("run", help="run file (HDF5)")
    parser.add_argument("--out", default=".", help="folder of the figures (default: here)")
    parser.add_argument("--format", default="png", choices=("png", "pdf"))
    options = parser.parse_args(arguments)
    try:
        for path in plot(options.run, options.out, options.format):
            print(path)
    except RunError as error:
        print(f"plot_run: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"plot_run: cannot write to {options.out}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
