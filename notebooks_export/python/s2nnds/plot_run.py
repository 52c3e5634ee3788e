# SPDX-License-Identifier: BSD-3-Clause
"""Figures of one run, from its run file alone, in the data's unit and frame.

    python -m s2nnds.plot_run RUN.h5 --out DIR [--format png|pdf]

2-D: phase_portrait, lyapunov, history. 3-D: the same and slices. More dimensions: pairwise projections. Poses: poses.
States (x, s) with x in the plane: phase_portrait in that plane, slices at several s, states in all three dimensions.
Prints the paths it wrote; exit code 2 and one line on stderr when the file or the folder cannot be used.
"""

import argparse
import os
import sys
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

from .isosurface import isosurface
from .run import Grid, Run, RunError, rotation_matrices, rotation_vectors

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


def with_grid(run):
    """A run as it is drawn: in the data's unit, with a grid that holds V, B and f up to three dimensions.

    Without a stored grid one is evaluated here from the networks, then without the sets.
    """
    n = run.dimension
    if n > 3:
        return run.in_data_unit()
    lower, upper = run.problem.workspace_lower, run.problem.workspace_upper
    count = 161 if n == 2 else 31
    grid = run.grid or Grid([np.linspace(low, high, count) for low, high in zip(lower, upper)])
    points = np.stack(np.meshgrid(*grid.axes, indexing="ij"), -1)
    for name in ("V", "B"):
        if getattr(grid, name) is None:
            setattr(grid, name, getattr(run, name)(points.reshape(-1, n)).reshape(points.shape[:-1]))
    if grid.velocity is None:
        grid.velocity = run.f(points.reshape(-1, n)).reshape(points.shape)
    run.grid = grid
    return run.in_data_unit()


def name_of(run):
    return run.name or "run"


def title_of(run):
    facts = []
    error, safe = (run.evaluation.get(key, np.nan) for key in ("mse_test", "safe_area_ratio"))
    if np.isfinite(error):
        in_unit = run.problem.frame == "data" and run.data.unit
        speed = run.data.velocity_scale * np.sqrt(error)
        facts.append(f"test error {speed:.3g} {run.data.unit}/s (RMS)" if in_unit else f"test MSE {error:.3g}")
    if np.isfinite(safe):
        facts.append(f"safe set {safe:.0%} of the truly safe one")
    stability = ", stability proved" if run.certificate["stability"].get("proved", 0) else ""
    return "\n".join([f"{name_of(run)}: guarantee {run.guarantee}{stability}", *([", ".join(facts)] if facts else [])])


def has_phase(run):
    """The motion is one in the plane with a phase."""
    return run.dimension == 3 and run.data.places == 2


def letter(run, k):
    if k == run.data.places:
        return "s"
    return "xyz"[k] if run.dimension <= 3 else f"$x_{{{k + 1}}}$"


def axis_label(run, k):
    frame = f" in {run.data.frame_name}" if run.data.frame_name else ""
    return f"{letter(run, k)}{frame}" + (f" [{run.data.unit}]" if run.data.unit else "")


def demonstration_groups(run):
    """(label, colour, positions of the demonstrations) of the train and the test demonstrations."""
    groups = (("demonstrations", TRAIN, run.data.train), ("test demonstrations", TEST, run.data.test))
    return [
        (label, colour, [run.data.demonstrations[k].position for k in indices])
        for label, colour, indices in groups
        if indices
    ]


def rollout_groups(run):
    """(label, line width, opacity, positions): from the demonstrations' starts, and from a grid's."""
    own = [rollout.position for rollout in run.rollouts if rollout.start_kind != "grid"]
    grid = [rollout.position for rollout in run.rollouts if rollout.start_kind == "grid"]
    groups = (("rollouts from the grid", 0.7, 0.55, grid), ("rollouts", 1.6, 1.0, own))
    return [group for group in groups if group[3]]


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


# ---------------------------------------------------------------- legends


def line(label, colour, width=1.6, **style):
    return Line2D([], [], color=colour, linewidth=width, label=label, **style)


def mark(label, marker, face, edge, size, **style):
    return Line2D(
        [],
        [],
        color="none",
        marker=marker,
        markerfacecolor=face,
        markeredgecolor=edge,
        markersize=size,
        label=label,
        **style,
    )


def goal_handle():
    return mark("goal", "*", GOAL, "black", 13)


def failed_handle():
    return mark("rollout stopped: unsafe or left", "x", "black", "black", 6, markeredgewidth=1.6)


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


# ---------------------------------------------------------------- drawing in a plane


def draw_goal(ax, run, i=0, j=1):
    ax.plot(
        *([place] for place in run.data.goal[[i, j]]),
        marker="*",
        color=GOAL,
        markeredgecolor="black",
        markeredgewidth=0.8,
        markersize=14,
        zorder=9,
    )


def draw_sets(ax, x, y, unsafe=None, initial=None, barrier=None):
    """The safe set, the unsafe set and X0 from their samples [len(x), len(y)]; returns legend handles."""

    def fill(level, face, edge, width, zorder):
        ax.contourf(x, y, level.T, levels=[-np.inf, 0.0], colors=[face], zorder=zorder)
        if has_zero(level):
            ax.contour(x, y, level.T, levels=[0.0], colors=[edge], linewidths=width, zorder=4)

    handles = []
    if reaches(barrier):
        fill(barrier, SAFE_FILL, SAFE_EDGE, 1.8, 0)
        handles.append(Patch(facecolor=SAFE_FILL, edgecolor=SAFE_EDGE, linewidth=1.8, label="safe set {B ≤ 0}"))
    if reaches(unsafe):
        fill(unsafe, UNSAFE_FILL, UNSAFE_EDGE, 1.2, 3)
        handles.append(Patch(facecolor=UNSAFE_FILL, edgecolor=UNSAFE_EDGE, label="unsafe set"))
    if has_zero(initial):
        style = {"linewidths": 1.4, "linestyles": ["--"], "zorder": 7}
        ax.contour(x, y, initial.T, levels=[0.0], colors=[INITIAL_EDGE], **style)
        handles.append(line("initial set", INITIAL_EDGE, 1.4, linestyle="--"))
    return handles


def draw_lines(ax, positions, i, j, **style):
    ax.add_collection(LineCollection([p[:, [i, j]] for p in positions], **style), autolim=False)


def near_plane(run):
    """How near to a plane the parts of motions are that are drawn in it."""
    return 0.03 * (run.problem.workspace_upper - run.problem.workspace_lower).max()


def shown_in(run, positions, at):
    """All of the motions [M, n], or with at = (fixed axis, its value) their parts near that plane."""
    if at is None:
        return positions
    fixed, value = at
    parts = []
    for p in positions:
        rows = np.flatnonzero(np.abs(p[:, fixed] - value) <= near_plane(run))
        parts += [p[part] for part in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1) if len(part) > 1]
    return parts


def draw_rollouts(ax, run, i=0, j=1, at=None):
    handles = []
    for label, width, alpha, positions in rollout_groups(run):
        draw_lines(ax, shown_in(run, positions, at), i, j, colors=ROLLOUT, linewidths=width, alpha=alpha, zorder=6)
        handles.append(line(label, ROLLOUT, width, alpha=alpha))
    return handles


def draw_motions(ax, run, i=0, j=1, at=None):
    """Demonstrations and rollouts, projected on the plane of axes i and j or cut (shown_in); returns legend handles."""
    handles = []
    for label, colour, positions in demonstration_groups(run):
        draw_lines(ax, shown_in(run, positions, at), i, j, colors=colour, linewidths=1.4, alpha=0.9, zorder=5)
        handles.append(line(label, colour))
    handles += draw_rollouts(ax, run, i, j, at)
    ends = failed_ends(run)
    if len(ends) and at is None:
        ax.plot(ends[:, i], ends[:, j], "x", color="black", markersize=6, markeredgewidth=1.6, zorder=8)
        handles.append(failed_handle())
    return handles


def draw_boxes(ax, boxes, i=0, j=1):
    """Boxes [k, 2n] that a proof left open; edges have a width of their own, so that tiny ones are seen."""
    if not len(boxes):
        return []
    n = boxes.shape[1] // 2
    patches = [Rectangle((box[i], box[j]), box[n + i] - box[i], box[n + j] - box[j]) for box in boxes]
    style = {"facecolor": OPEN_BOX, "edgecolor": OPEN_BOX}
    ax.add_collection(PatchCollection(patches, linewidths=1.2, zorder=7.5, **style), autolim=False)
    return [Patch(label="open boxes of the proof", **style)]


def frame(ax, run, i=0, j=1):
    """Equal axes over the workspace, with the containment box where there is one."""
    lower, upper = run.problem.workspace_lower[[i, j]], run.problem.workspace_upper[[i, j]]
    share = run.problem.containment
    if 0.0 < share < 1.0:
        corner = 0.5 * (lower + upper) - 0.5 * share * (upper - lower)
        style = {"edgecolor": "#666666", "linewidth": 0.8, "linestyle": ":", "zorder": 2}
        ax.add_patch(Rectangle(corner, *(share * (upper - lower)), fill=False, **style))
    ax.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]))
    ax.set_aspect("equal")
    ax.set_xlabel(axis_label(run, i))
    ax.set_ylabel(axis_label(run, j))


# ---------------------------------------------------------------- phase portrait


def draw_flow(ax, x, y, velocity, **style):
    """Streamlines of samples [len(x), len(y), 2]; streamplot wants spacings equal to the last bit."""
    style = {"color": FLOW, "density": 1.5, "linewidth": 0.6, "arrowsize": 0.8, "zorder": 1, **style}
    places = [np.linspace(axis[0], axis[-1], len(axis)) for axis in (x, y)]
    ax.streamplot(*places, velocity[..., 0].T, velocity[..., 1].T, **style)
    return [line("flow of f", FLOW, 1.0)]


def draw_phase_portrait(ax, run):
    """All that Fig. 2 of the paper shows of a planar run; returns legend handles."""
    grid = run.grid
    handles = draw_sets(ax, *grid.axes, grid.unsafe, grid.initial, grid.B)
    flow = draw_flow(ax, *grid.axes, grid.velocity)
    handles += draw_motions(ax, run)
    handles += draw_boxes(ax, all_open_boxes(run))
    draw_goal(ax, run)
    frame(ax, run)
    return handles + [goal_handle()] + flow


def phase_portrait_2d(run):
    width, height = (np.ptp(axis) for axis in run.grid.axes)
    shape = np.clip(height / width, 0.4, 1.6)  # of the axes; what stands around them takes an inch of height
    figure, ax = plt.subplots(figsize=(6.2, 1.0 + 5.2 * shape), constrained_layout=True)
    handles = draw_phase_portrait(ax, run)
    ax.set_title(title_of(run))
    legend_below(figure, handles)
    return figure


PHASES = (1.0, 0.75, 0.5, 0.25, 0.0)  # shares of the start at which a motion with a phase is shown


def at_phase(run, share):
    """The plane of the places where the phase is nearest to this share of its start: its number and value, and the fields."""
    index = nearest(run.grid.axes[2], share * run.data.phase_start)
    return index, run.grid.axes[2][index], plane(run.grid, 2, index)[2]


def phase_portrait_of_places(run):
    """Motions in the plane, whatever the phase; the safe set is that of the places where a motion may start."""
    _, value, cut = at_phase(run, 1.0)
    width, height = (np.ptp(axis) for axis in cut.axes)
    figure, ax = plt.subplots(figsize=(6.2, 1.0 + 5.2 * np.clip(height / width, 0.4, 1.6)), constrained_layout=True)
    handles = draw_sets(ax, *cut.axes, cut.unsafe, cut.initial, cut.B)
    for handle in handles:
        if handle.get_label().startswith("safe set"):
            handle.set_label(f"safe starts: {{B ≤ 0}} at s = {value:.3g} {run.data.unit}".rstrip())
    handles += draw_motions(ax, run)
    draw_goal(ax, run)
    frame(ax, run)
    ax.set_title(title_of(run))
    legend_below(figure, handles + [goal_handle()])
    return figure


def slices_of_phase(run):
    """The safe set and the flow while the phase runs down, with the parts of the motions at that time."""
    figure, axes = plt.subplots(2, 3, figsize=(10.5, 7.8), squeeze=False, constrained_layout=True)
    handles = []
    for ax, share in zip(axes.flat, PHASES):
        index, value, cut = at_phase(run, share)
        handles += draw_sets(ax, *cut.axes, cut.unsafe, cut.initial, cut.B)
        handles += draw_flow(ax, *cut.axes, cut.velocity[..., :2], density=0.9)
        handles += draw_motions(ax, run, at=(2, value))
        boxes = all_open_boxes(run)
        handles += draw_boxes(ax, boxes[(boxes[:, 2] <= value) & (value <= boxes[:, 5])])
        if share == PHASES[-1]:
            draw_goal(ax, run)
        frame(ax, run)
        ax.set_title(fixed_text(run, 2, index), fontsize=10)
    axes.flat[-1].axis("off")
    figure.suptitle(f"{title_of(run)}\n(of demonstrations and rollouts the parts while s is near that value)", fontsize=11)
    legend_below(figure, handles + [goal_handle()], columns=4)
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
    style = {"edgecolors": "none", "linewidths": 0, "antialiaseds": False, "rasterized": True}
    ax.add_collection3d(Poly3DCollection(triangles, facecolors=colours, zorder=zorder, **style))


def phase_portrait_3d(run):
    figure = plt.figure(figsize=(7.0, 6.6))
    ax = figure.add_axes([0.02, 0.04, 0.92, 0.88], projection="3d", computed_zorder=False)
    grid, handles = run.grid, []
    for level, surface, patch, label in (
        (grid.B, ("#4fc04f", 0.10, 1, 26), (SAFE_FILL, SAFE_EDGE), "boundary of the safe set"),
        (grid.unsafe, ("#e5534b", 0.75, 3, 60), (UNSAFE_FILL, UNSAFE_EDGE), "unsafe set"),
        (grid.initial, ("#555555", 0.25, 4, 60), ("#bbbbbb", "#555555"), "initial set"),
    ):
        if has_zero(level):
            draw_surface(ax, grid.axes, level, *surface)
            handles.append(Patch(facecolor=patch[0], edgecolor=patch[1], label=label))
    # Not add_collection3d for lines: from matplotlib 3.10 on it wants them of equal length.
    for label, colour, positions in demonstration_groups(run):
        ax.add_collection(Line3DCollection(positions, colors=colour, linewidths=1.3, zorder=5))
        handles.append(line(label, colour))
    for label, width, alpha, positions in rollout_groups(run):
        style = {"linewidths": width, "alpha": alpha, "zorder": 6}
        ax.add_collection(Line3DCollection(positions, colors=ROLLOUT, **style))
        handles.append(line(label, ROLLOUT, width, alpha=alpha))
    ends = failed_ends(run)
    if len(ends):
        ax.plot(*ends.T, "x", color="black", zorder=8)
        handles.append(failed_handle())
    boxes = all_open_boxes(run)
    if len(boxes):
        ax.plot(*(0.5 * (boxes[:, :3] + boxes[:, 3:])).T, "s", color=OPEN_BOX, markersize=3, zorder=7)
        handles.append(mark("open boxes of the proof (centres)", "s", OPEN_BOX, OPEN_BOX, 4))
    ax.plot(
        *run.data.goal[:, None], marker="*", color=GOAL, markeredgecolor="black", markersize=15, zorder=9
    )
    handles.append(goal_handle())
    lower, upper = run.problem.workspace_lower, run.problem.workspace_upper
    ax.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    ax.set_box_aspect(upper - lower, zoom=0.92)  # room for the labels
    ax.set(xlabel=axis_label(run, 0), ylabel=axis_label(run, 1), zlabel=axis_label(run, 2))
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
        draw_goal(ax, run, i, j)
        frame(ax, run, i, j)
    for ax in axes.flat[len(pairs) :]:
        ax.axis("off")
    figure.suptitle(title_of(run) + "\nprojections of the trajectories", fontsize=11)
    legend_below(figure, handles + [goal_handle()])
    return figure


# ---------------------------------------------------------------- slices of a 3-D run


def nearest(axis, value):
    return int(np.argmin(np.abs(axis - value)))


def plane(grid, fixed, index):
    """The two other axes' numbers and the grid's fields where axis `fixed` has its value of number `index`."""
    i, j = (k for k in range(3) if k != fixed)
    names = ("unsafe", "initial", "V", "B", "velocity")
    fields = {name: getattr(grid, name) for name in names}
    cut = {name: None if f is None else np.take(f, index, axis=fixed) for name, f in fields.items()}
    return i, j, Grid([grid.axes[i], grid.axes[j]], **cut)


def fixed_text(run, fixed, index):
    return f"{letter(run, fixed)} = {run.grid.axes[fixed][index]:.3g} {run.data.unit}".rstrip()


def slices(run):
    """Planes through the goal and, where there is an obstacle, through its deepest point."""
    grid = run.grid
    centres = [("goal", run.data.goal)]
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
            handles += draw_slice(ax, run, fixed, index)
            ax.set_title(f"through the {name}: {fixed_text(run, fixed, index)}", fontsize=10)
    figure.suptitle(
        f"{title_of(run)}\n(of demonstrations and rollouts what is within {near_plane(run):.2g} {run.data.unit}".rstrip()
        + " of a plane)",
        fontsize=11,
    )
    legend_below(figure, handles + [goal_handle()], columns=4)
    return figure


def draw_slice(ax, run, fixed, index):
    i, j, cut = plane(run.grid, fixed, index)
    x, y = cut.axes
    handles = draw_sets(ax, x, y, cut.unsafe, cut.initial, cut.B)
    step = max(1, len(x) // 14)
    u, v = cut.velocity[::step, ::step, i].T, cut.velocity[::step, ::step, j].T
    # the direction matters here, the speed does not: square roots keep slow arrows visible
    root = np.sqrt(np.maximum(np.hypot(u, v), 1e-12))
    ax.quiver(x[::step], y[::step], u / root, v / root, color=FLOW, width=0.004, zorder=1)
    handles += [line("flow of f, in the plane", FLOW, 1.0)]
    value = run.grid.axes[fixed][index]
    handles += draw_motions(ax, run, i, j, (fixed, value))
    boxes = all_open_boxes(run)
    meets = (boxes[:, fixed] <= value) & (value <= boxes[:, 3 + fixed])
    handles += draw_boxes(ax, boxes[meets], i, j)
    if abs(run.data.goal[fixed] - value) <= near_plane(run):
        draw_goal(ax, run, i, j)
    frame(ax, run, i, j)
    return handles


# ---------------------------------------------------------------- Lyapunov function


def draw_levels(ax, x, y, V, norm, levels):
    """V [len(x), len(y)] in colours and level sets; where V <= 0 the condition fails: grey."""
    style = {"cmap": "YlGnBu", "shading": "gouraud", "rasterized": True, "zorder": 0}
    mesh = ax.pcolormesh(x, y, np.fmax(V, norm.vmin).T, norm=norm, **style)
    ax.contour(x, y, V.T, levels=levels, colors="#30506a", linewidths=0.7, zorder=1)
    handles = [line("level sets of V", "#30506a", 0.9)]
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


def lyapunov_in_planes(run, planes, figsize):
    """One panel per plane: (i, j, Grid, title, the fixed axis and its value or None)."""
    norm, levels = log_levels(np.concatenate([cut.V.ravel() for _, _, cut, *_ in planes]))
    if norm is None:
        return lyapunov_along_motions(run)
    figure, axes = plt.subplots(1, len(planes), figsize=figsize, squeeze=False, constrained_layout=True)
    handles = []
    for ax, (i, j, cut, title, at) in zip(axes.flat, planes):
        mesh, more = draw_levels(ax, *cut.axes, cut.V, norm, levels)
        handles += more
        if has_zero(cut.B):
            ax.contour(*cut.axes, cut.B.T, levels=[0.0], colors=[SAFE_EDGE], linewidths=1.8, zorder=4)
            handles.append(line("boundary of the safe set", SAFE_EDGE, 1.8))
        handles += draw_sets(ax, *cut.axes, cut.unsafe)
        handles += draw_rollouts(ax, run, i, j, at)
        draw_goal(ax, run, i, j)
        frame(ax, run, i, j)
        ax.set_title(title, fontsize=10)
    figure.suptitle(f"{name_of(run)}: Lyapunov function", fontsize=11)
    figure.colorbar(mesh, ax=axes, label="V", shrink=0.85, pad=0.02, extend="min")
    legend_below(figure, handles + [goal_handle()], columns=4 if len(planes) > 1 else 3)
    return figure


def lyapunov_along_motions(run):
    figure, ax = plt.subplots(figsize=(6.4, 4.2), constrained_layout=True)
    handles = []
    motions = [(ROLLOUT, 1.0, "rollouts", rollout) for rollout in run.rollouts]
    motions += [(TRAIN, 0.6, "demonstrations", demonstration) for demonstration in run.data.demonstrations]
    for colour, width, label, motion in motions:
        value = run.V(run.data.to_normalized(motion.position))
        ax.plot(motion.time - motion.time[0], value, color=colour, linewidth=width)
        handles.append(line(label, colour, width + 0.6))
    ax.set_yscale("log")
    low, high = ax.get_ylim()
    ax.set_ylim(max(low, 1e-7 * high), high)  # V = 0 at the goal would stretch the axis without end
    ax.set_xlabel("time [s]")
    ax.set_ylabel("V")
    ax.grid(alpha=0.3)
    ax.set_title(f"{name_of(run)}: Lyapunov function along the motions")
    if handles:
        legend_below(figure, handles)
    return figure


def lyapunov(run):
    if run.dimension > 3:
        return lyapunov_along_motions(run)
    if run.dimension == 2:
        return lyapunov_in_planes(run, [(0, 1, run.grid, "", None)], (6.8, 5.8))
    planes = []
    for fixed in (2, 1, 0):
        index = nearest(run.grid.axes[fixed], run.data.goal[fixed])
        at = fixed, run.grid.axes[fixed][index]
        planes.append((*plane(run.grid, fixed, index), fixed_text(run, fixed, index), at))
    return lyapunov_in_planes(run, planes, (11.5, 4.2))


# ---------------------------------------------------------------- poses

FRAME_AXES = (("x", "#c62828"), ("y", "#2e7d32"), ("z", "#1565c0"))  # of what moves


def in_space(position):
    """[N, 3] of positions [N, 2] or [N, 3]."""
    return np.pad(position, ((0, 0), (0, 3 - position.shape[1])))


def draw_frames(ax, motion, length, count, **style):
    """The axes of what moves at `count` places evenly spaced along its path."""
    position = in_space(motion.position)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(position, axis=0), axis=1))])
    places = np.unique(np.searchsorted(along, np.linspace(0.0, along[-1], count)).clip(0, len(along) - 1))
    axes = rotation_matrices(motion.orientation[places])
    for k, (_, colour) in enumerate(FRAME_AXES):
        ends = position[places] + length * axes[:, :, k]
        ax.add_collection(Line3DCollection(np.stack([position[places], ends], axis=1), colors=colour, **style))


def draw_poses(ax, run):
    motions = [rollout for rollout in run.rollouts if rollout.orientation is not None]
    shown = [run.data.demonstrations[k] for k in run.data.train]
    all_positions = in_space(np.concatenate([motion.position for motion in shown + motions]))
    lower, upper = all_positions.min(0), all_positions.max(0)
    length = 0.13 * np.max(upper - lower)
    ax.add_collection(Line3DCollection([in_space(d.position) for d in shown], colors=TRAIN, linewidths=0.9, alpha=0.5))
    ax.add_collection(Line3DCollection([in_space(m.position) for m in motions], colors=ROLLOUT, linewidths=1.5))
    for motion in motions[:2]:
        draw_frames(ax, motion, length, 11, linewidths=1.6)
    ax.plot(*in_space(run.data.goal[None]).T, marker="*", color=GOAL, markeredgecolor="black", markersize=13)
    middle, half = 0.5 * (lower + upper), 0.5 * np.max(upper - lower) + length
    ax.set(xlim=middle[0] + [-half, half], ylim=middle[1] + [-half, half], zlim=middle[2] + [-half, half])
    ax.set_box_aspect((1, 1, 1), zoom=1.0)
    ax.set(xlabel=axis_label(run, 0), ylabel=axis_label(run, 1), zlabel=axis_label(run, 2) if run.dimension == 3 else "")
    ax.view_init(elev=24, azim=-58)
    ax.set_title("frames along the first two motions", fontsize=10)
    frames = [line(f"{name} axis of what moves", colour) for name, colour in FRAME_AXES]
    return [line("demonstrations", TRAIN), line("rollouts", ROLLOUT), *frames, goal_handle()]


def draw_turns(ax, run, k):
    """One component of log(q_goal^-1 q) over time."""
    goal = run.data.goal_orientation
    for motions, colour, width in (
        ([run.data.demonstrations[i] for i in run.data.train], TRAIN, 0.9),
        ([run.data.demonstrations[i] for i in run.data.test], TEST, 0.9),
        (run.rollouts, ROLLOUT, 1.3),
    ):
        for motion in motions:
            if motion.orientation is None:
                continue
            turn = np.degrees(rotation_vectors(goal, motion.orientation)[:, k])
            ax.plot(motion.time - motion.time[0], turn, color=colour, linewidth=width)
    ax.axhline(0.0, color="#888888", linewidth=0.7)
    ax.set_ylabel(f"$r_{k + 1}$ [degrees]")
    ax.grid(alpha=0.3)


def poses(run):
    """Frames along the motions, and the rotation from the goal's orientation over time; None without orientations."""
    if run.data.goal_orientation is None or not any(rollout.orientation is not None for rollout in run.rollouts):
        return None
    figure = plt.figure(figsize=(11.5, 5.6), constrained_layout=True)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.3, 1))
    handles = draw_poses(figure.add_subplot(grid[:, 0], projection="3d"), run)
    for k in range(3):
        ax = figure.add_subplot(grid[k, 1])
        draw_turns(ax, run, k)
        if k == 0:
            ax.set_title("rotation vector from the goal's orientation", fontsize=10)
    ax.set_xlabel("time [s]")
    if run.data.test:
        handles.append(line("test demonstrations", TEST))
    turning = run.certificate.get("orientation", {})
    proved = run.guarantee == "invariant" and turning.get("proved", 0)
    words = (
        f"orientation proved to converge from errors up to {np.degrees(turning['initial_error']):.1f} degrees"
        if proved
        else "nothing is guaranteed of the orientation"
    )
    figure.suptitle(f"{title_of(run)}\n{words}", fontsize=11)
    legend_below(figure, handles, columns=4)
    return figure


# ---------------------------------------------------------------- history

# What the numbers of the column `stage` stand for, and how their rounds are shaded.
STAGES = (("search", None), ("imitation fine-tuning", "#dfe8fb"), ("enlarging", "#fbf0d9"))
TERMS = ("loss", "imitation", "lyapunov", "barrier_sets", "barrier_decrease", "rollout_safety", "obstacle_normal")


def history_panels(columns):
    """[(question, columns, scale)]; a column that is zero throughout, or never a number, answers none."""
    columns = {name: np.asarray(column, dtype=float) for name, column in columns.items()}
    told = {name: column for name, column in columns.items() if np.isfinite(column).any() and np.nan_to_num(column).any()}
    losses = {("their sum" if name == "loss" else name): told[name] for name in TERMS if name in told}
    found = {name.removeprefix("count_"): told[name] for name in told if name.startswith("count_")}
    # A round without rollouts (the warm start) has no share.
    share = told.get("safe_share")
    safe = {} if share is None else {"rollouts that stay safe": np.where(share > 0, share, np.nan)}
    panels = (
        ("How large is each term of the loss, with its weight?", losses, "log"),
        ("How many counterexamples were found, and to which condition?", found, "symlog"),
        ("Which share of the workspace is safe?", safe, "linear"),
    )
    return [panel for panel in panels if panel[1]]


def shade_stages(ax, rounds, stages):
    """Colours the rounds of every stage but the search; returns legend handles."""
    handles = {}
    for first, stage in zip(rounds, stages):
        name, colour = STAGES[int(stage)] if 0 <= stage < len(STAGES) else ("another stage", "#eeeeee")
        if colour:
            ax.axvspan(first - 0.5, first + 0.5, facecolor=colour, linewidth=0, zorder=0)
            handles[name] = Patch(facecolor=colour, label=name)
    return list(handles.values())


def draw_columns(ax, rounds, question, columns, scale):
    colours = plt.get_cmap("tab10").colors
    for k, (name, column) in enumerate(columns.items()):
        colour, width = ("#222222", 2.0) if name == "their sum" else (colours[k % 10], 1.3)
        shown = np.where(column > 0.0, column, np.nan) if scale == "log" else column
        label = name.replace("_", " ")
        ax.plot(rounds, shown, marker="o", markersize=3.5, linewidth=width, color=colour, label=label)
    if scale == "log":
        ax.set_yscale("log")
        ax.yaxis.set_minor_formatter(LogFormatterSciNotation(labelOnlyBase=False, minor_thresholds=(2, 0.5)))
    elif scale == "symlog":
        ax.set_yscale("symlog", linthresh=1.0)  # zero is the aim, so it must be on the axis
        ax.set_ylim(bottom=-0.15)
    ax.set_title(question, fontsize=10)
    ax.set_xlim(rounds[0] - 0.5, rounds[-1] + 0.5)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.grid(alpha=0.3)


def history(run):
    panels = history_panels(run.history)
    if not panels:
        return None
    count = len(next(iter(run.history.values())))
    rounds = np.asarray(run.history.get("round", np.arange(count)))
    stages = np.asarray(run.history.get("stage", np.zeros(count)))
    figure, axes = plt.subplots(
        len(panels), 1, figsize=(7.2, 2.5 * len(panels) + 0.4), squeeze=False, constrained_layout=True
    )
    for ax, panel in zip(axes.flat, panels):
        draw_columns(ax, rounds, *panel)
        shades = shade_stages(ax, rounds, stages)
        handles = ax.get_legend_handles_labels()[0] + (shades if ax is axes[0][0] else [])
        ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, borderaxespad=0.0)
    axes[-1][0].set_xlabel("round (0: warm start)")
    figure.suptitle(f"{name_of(run)}: training history", fontsize=11)
    return figure


# ---------------------------------------------------------------- pushes


def pushes(run):
    """Where on the training demonstrations an arm withstands which push, drawn over the safe set."""
    figure, ax = plt.subplots(figsize=(7.0, 6.2), constrained_layout=True)
    grid, handles = run.grid, []
    if run.dimension == 2 and grid is not None:
        handles = draw_sets(ax, *grid.axes, grid.unsafe, grid.initial, grid.B)
    order = np.argsort(-run.pushes[:, -1])  # the weakest on top
    places = run.pushes[order]
    dots = ax.scatter(places[:, 0], places[:, 1], c=places[:, -1], s=10, cmap="viridis", vmin=0.0, zorder=6)
    figure.colorbar(dots, ax=ax, label="largest push [N s]", shrink=0.8)
    draw_goal(ax, run)
    frame(ax, run)
    damping, least = (run.certificate["execution"][key] for key in ("damping", "least_push"))
    ax.set_title(f"{name_of(run)}: pushes withstood at {damping:g} N s/m, at least {least:.3g} N s", fontsize="medium")
    legend_below(figure, handles + [goal_handle()])
    return figure


# ---------------------------------------------------------------- the program


def make_figures(run):
    """name -> figure; what the run has no data for is left out."""
    run = with_grid(run)
    if run.dimension == 2:
        yield "phase_portrait", phase_portrait_2d(run)
    elif has_phase(run):
        yield "phase_portrait", phase_portrait_of_places(run)
        yield "slices", slices_of_phase(run)
        yield "states", phase_portrait_3d(run)
    elif run.dimension == 3:
        yield "phase_portrait", phase_portrait_3d(run)
        yield "slices", slices(run)
    else:
        yield "phase_portrait", projections(run)
    yield "lyapunov", lyapunov(run)
    for name, make in (("poses", poses), ("history", history)):
        figure = make(run)
        if figure is not None:
            yield name, figure
    if run.pushes is not None:
        yield "pushes", pushes(run)


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
