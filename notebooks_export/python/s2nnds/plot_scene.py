# SPDX-License-Identifier: BSD-3-Clause
"""The figure of `s2nnds new` and `s2nnds preview`: recordings, obstacle, initial set and workspace, in the data's unit.

    python -m s2nnds.plot_scene SCENE.h5 --out FIGURE.png
"""

import argparse
import os
import sys
from dataclasses import dataclass

import h5py
import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch, Rectangle

from .plot_run import (
    GOAL,
    STYLE,
    UNSAFE_EDGE,
    UNSAFE_FILL,
    draw_sets,
    draw_surface,
    goal_handle,
    has_zero,
    legend_below,
    line,
    mark,
    save,
)

CROSSING = "#f57c00"
GAP = "#6a1b9a"


@dataclass
class Scene:
    """What the program found; everything but the demonstrations may be missing (None)."""

    name: str
    unit: str
    frame: str
    times: list  # K of [M]
    positions: list  # K of [M, n]
    speeds: list  # K of [M]
    goal: np.ndarray | None
    lower: np.ndarray | None  # the workspace
    upper: np.ndarray | None
    axes: list | None
    unsafe: np.ndarray | None  # levels on the grid of the axes
    initial: np.ndarray | None
    crossings: np.ndarray  # [C, n]
    clearances: np.ndarray  # [K, 2, n]: from the demonstration to the obstacle


def read(path):
    with h5py.File(path) as file:

        def array(item):
            return file[item][()] if item in file else None

        group = file["demonstrations"]
        items = [group[key] for key in sorted(group, key=int)]
        n = items[0]["position"].shape[1]
        crossings, gaps = array("crossings"), array("clearances")
        return Scene(
            group.attrs["name"],
            group.attrs["unit"],
            group.attrs["frame"],
            [item["time"][()] for item in items],
            [item["position"][()] for item in items],
            [item["speed"][()] for item in items],
            array("goal"),
            array("workspace/lower"),
            array("workspace/upper"),
            [file[f"axes/{i}"][()] for i in range(n)] if "axes" in file else None,
            array("unsafe"),
            array("initial"),
            np.zeros((0, n)) if crossings is None else crossings,
            np.zeros((0, 2, n)) if gaps is None else gaps.reshape(-1, 2, n),
        )


def colours(scene):
    count = len(scene.positions)
    return [plt.get_cmap("viridis")(0.85 * k / max(1, count - 1)) for k in range(count)]


def axis_label(scene, k):
    letter = "xyz"[k] if scene.positions[0].shape[1] <= 3 else f"$x_{{{k + 1}}}$"
    frame = f" in {scene.frame}" if scene.frame else ""
    return f"{letter}{frame} [{scene.unit}]" if scene.unit else f"{letter}{frame}"


def limits(scene):
    """Of the axes: the workspace, or the box around the demonstrations with some room."""
    if scene.lower is not None:
        return scene.lower, scene.upper
    positions = np.concatenate(scene.positions)
    low, high = positions.min(axis=0), positions.max(axis=0)
    room = 0.1 * (high - low).max()
    return low - room, high + room


def demonstration_handles(scene):
    tones = colours(scene)
    if len(tones) <= 6:
        return [line(f"demonstration {k}", tone) for k, tone in enumerate(tones)]
    return [line("demonstration 0", tones[0]), line(f"... demonstration {len(tones) - 1}", tones[-1])]


def mark_handles(scene):
    handles = [mark("starts", "o", "white", "black", 5)]
    if scene.goal is not None:
        handles.append(goal_handle())
    if len(scene.crossings):
        handles.append(mark("crossing", "X", CROSSING, "black", 9))
    if len(scene.clearances):
        handles.append(line("clearance", GAP, 1.2, linestyle=":"))
    return handles


def draw_marks(ax, scene, places):
    """Starts, goal, crossings and clearances in the coordinates `places`."""
    starts = np.array([p[0] for p in scene.positions])[:, places]
    style = {"linestyle": "none", "markeredgecolor": "black"}
    ax.plot(*starts.T, marker="o", markersize=5, markerfacecolor="white", zorder=8, **style)
    if scene.goal is not None:
        ax.plot(*scene.goal[places].reshape(-1, 1), marker="*", markersize=14, markerfacecolor=GOAL, zorder=9, **style)
    if len(scene.crossings):
        ax.plot(*scene.crossings[:, places].T, marker="X", markersize=9, markerfacecolor=CROSSING, zorder=10, **style)
    for ends in scene.clearances[:, :, places]:
        ax.plot(*ends.T, color=GAP, linewidth=1.2, linestyle=":", zorder=7)


def draw_plane(ax, scene, i=0, j=1):
    """The plane of the axes i and j; sets only where there are no other axes."""
    handles = []
    if scene.axes is not None and scene.unsafe is not None and len(scene.axes) == 2:
        handles = draw_sets(ax, *scene.axes, scene.unsafe, scene.initial)
    for positions, tone in zip(scene.positions, colours(scene)):
        ax.plot(positions[:, i], positions[:, j], color=tone, linewidth=1.5, zorder=5)
    draw_marks(ax, scene, [i, j])
    low, high = limits(scene)
    if scene.lower is not None:
        ax.add_patch(Rectangle(low[[i, j]], *(high - low)[[i, j]], fill=False, edgecolor="#666666", linewidth=1.2, zorder=2))
        handles.append(Patch(facecolor="none", edgecolor="#666666", label="workspace"))
    room = 0.02 * (high - low)
    ax.set(xlim=(low[i] - room[i], high[i] + room[i]), ylim=(low[j] - room[j], high[j] + room[j]))
    ax.set_aspect("equal")
    ax.set(xlabel=axis_label(scene, i), ylabel=axis_label(scene, j))
    ax.grid(alpha=0.25)
    return handles


def draw_space(ax, scene):
    handles = []
    if scene.axes is not None and scene.unsafe is not None:
        for level, colour, alpha, patch, label in (
            (scene.unsafe, "#e5534b", 0.75, (UNSAFE_FILL, UNSAFE_EDGE), "unsafe set"),
            (scene.initial, "#555555", 0.25, ("#bbbbbb", "#555555"), "initial set"),
        ):
            if has_zero(level):
                draw_surface(ax, scene.axes, level, colour, alpha, 3, 52)
                handles.append(Patch(facecolor=patch[0], edgecolor=patch[1], label=label))
    for positions, tone in zip(scene.positions, colours(scene)):
        ax.plot(*positions.T, color=tone, linewidth=1.5, zorder=5)
    draw_marks(ax, scene, [0, 1, 2])
    low, high = limits(scene)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(high - low)
    ax.set(xlabel=axis_label(scene, 0), ylabel=axis_label(scene, 1), zlabel=axis_label(scene, 2))
    return handles


def draw_coordinates(ax, scene):
    """More than three dimensions: each coordinate of the first demonstration over time, the others faint."""
    tones = plt.get_cmap("tab10").colors
    for k, (times, positions) in enumerate(zip(scene.times, scene.positions)):
        for i in range(positions.shape[1]):
            ax.plot(times, positions[:, i], color=tones[i % 10], linewidth=1.4 if k == 0 else 0.7, alpha=1 if k == 0 else 0.4)
    ax.set(xlabel="time [s]", ylabel=f"coordinates [{scene.unit}]" if scene.unit else "coordinates")
    ax.grid(alpha=0.25)
    return [line(f"$x_{{{i + 1}}}$", tones[i % 10]) for i in range(scene.positions[0].shape[1])]


def draw_speeds(ax, scene):
    for times, speeds, tone in zip(scene.times, scene.speeds, colours(scene)):
        ax.plot(times, speeds, color=tone, linewidth=1.3)
    ax.set_ylim(bottom=0)
    ax.set(xlabel="time [s]", ylabel=f"speed [{scene.unit}/s]" if scene.unit else "speed [1/s]")
    ax.grid(alpha=0.25)
    ax.set_title("How fast is each?", fontsize=10)


def draw(scene):
    n = scene.positions[0].shape[1]
    figure = plt.figure(figsize=(11.0, 5.6), constrained_layout=True)
    columns = figure.add_gridspec(1, 2, width_ratios=(1.5, 1))
    ax = figure.add_subplot(columns[0], **({"projection": "3d", "computed_zorder": False} if n == 3 else {}))
    handles = draw_plane(ax, scene) if n == 2 else draw_space(ax, scene) if n == 3 else draw_coordinates(ax, scene)
    draw_speeds(figure.add_subplot(columns[1]), scene)
    figure.suptitle(f"{scene.name}: {len(scene.positions)} demonstration(s)", fontsize=11)
    legend_below(figure, demonstration_handles(scene) + (mark_handles(scene) if n <= 3 else []) + handles, columns=5)
    return figure


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Recordings and sets, before any training.")
    parser.add_argument("scene", help="file that the program wrote (HDF5)")
    parser.add_argument("--out", required=True, help="figure (PNG)")
    options = parser.parse_args(arguments)
    try:
        with plt.rc_context(STYLE):
            save(draw(read(options.scene)), options.out, "png")
    except OSError as error:
        print(f"plot_scene: cannot write {os.path.basename(options.out)}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
