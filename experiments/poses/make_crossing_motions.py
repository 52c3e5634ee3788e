#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes seven motions in the plane that cross themselves or end where they start, each with an obstacle that cannot be
passed on another side: five recordings that differ a little, and a configuration.

    python3 make_crossing_motions.py FOLDER     # FOLDER/circle/config.toml, FOLDER/stroke/config.toml, ...
"""

import argparse
import os

import numpy as np
from scipy.interpolate import CubicSpline

DEMONSTRATIONS = 5
SECONDS = 4.0
SAMPLES = 201

HEAD = """name = "{name}"

[data]
source = "csv"
files = ["d*.csv"]
unit = "m"

[problem]
unsafe = {unsafe}
"""


def circle(share):
    angle = 2 * np.pi * share
    return np.column_stack([0.2 * np.cos(angle), 0.2 * np.sin(angle)])


def trochoid(loops):
    """A stroke to the right with loops, 0.5 m long."""

    def place(share):
        angle = 2 * np.pi * (loops + 1) * share
        return np.column_stack([0.5 * share - 0.09 * np.sin(angle), 0.09 * (1 - np.cos(angle))])

    return place


def through(points):
    """A smooth curve through points [m], with time in proportion to the distances between them."""
    points = np.array(points)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return CubicSpline(length / length[-1], points)


def letter_o(share):
    """From the top counterclockwise, and a little way over the start."""
    angle = np.pi / 2 + 2.25 * np.pi * share
    return np.column_stack([0.12 * np.cos(angle), 0.16 * np.sin(angle)])


def eight(share):
    """From the middle through both loops back to the middle."""
    angle = 2 * np.pi * share
    return np.column_stack([0.25 * np.sin(angle), 0.12 * np.sin(2 * angle)])


LETTER_E = through([[0.0, 0.0], [0.1, 0.02], [0.19, 0.07], [0.19, 0.15], [0.12, 0.19], [0.04, 0.15], [0.01, 0.05],
                    [0.04, -0.05], [0.13, -0.08], [0.23, -0.05], [0.3, 0.0]])  # fmt: skip
LETTER_L = through([[0.0, 0.0], [0.08, 0.05], [0.15, 0.15], [0.185, 0.27], [0.17, 0.35], [0.135, 0.36], [0.105, 0.3],
                    [0.1, 0.18], [0.11, 0.07], [0.15, 0.0], [0.21, 0.01], [0.26, 0.05]])  # fmt: skip


def minimum_jerk(share):
    return share**3 * (10 - 15 * share + 6 * share**2)


def constant(share):
    return share


def balls(*each):
    regions = [f'{{ type = "ball", center = [{x}, {y}], radius = {radius} }}' for x, y, radius in each]
    return regions[0] if len(regions) == 1 else f'{{ type = "union", of = [{", ".join(regions)}] }}'


# The curve, how it is gone along, and the obstacle.
MOTIONS = {
    "circle": (circle, constant, balls((0.0, 0.0, 0.06))),
    "stroke": (trochoid(1), minimum_jerk, balls((0.25, -0.06, 0.04))),
    "letter_e": (LETTER_E, minimum_jerk, balls((0.105, 0.105, 0.03))),
    "letter_o": (letter_o, minimum_jerk, balls((0.0, 0.0, 0.05))),
    "two_loops": (trochoid(2), minimum_jerk, balls((0.25, -0.06, 0.03))),
    "letter_l": (LETTER_L, minimum_jerk, balls((0.145, 0.27, 0.018))),
    "eight": (eight, minimum_jerk, balls((0.15, 0.0, 0.04), (-0.15, 0.0, 0.04))),
}


def varied(place, rng):
    """The curve, a little larger or smaller, turned, moved and bent."""
    size, turn = 1 + rng.uniform(-0.02, 0.02), rng.uniform(-0.02, 0.02)
    move, bend, phase = rng.uniform(-0.003, 0.003, 2), rng.uniform(-0.003, 0.003, 2), rng.uniform(0, 2 * np.pi)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])

    def changed(share):
        wave = np.sin(2 * np.pi * share + phase)[:, None]
        return size * place(share) @ rotation.T + move + wave * bend

    return changed


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder")
    out = parser.parse_args().folder
    for k, (name, (place, pace, unsafe)) in enumerate(MOTIONS.items()):
        folder = os.path.join(out, name)
        os.makedirs(folder, exist_ok=True)
        rng = np.random.default_rng(k)
        for number in range(DEMONSTRATIONS):
            seconds = SECONDS * (1 + rng.uniform(-0.1, 0.1))
            share = np.linspace(0.0, 1.0, SAMPLES)
            table = np.column_stack([seconds * share, varied(place, rng)(pace(share))])
            path = os.path.join(folder, f"d{number}.csv")
            np.savetxt(path, table, fmt="%.6f", delimiter=",", header="time,x,y", comments="")
        with open(os.path.join(folder, "config.toml"), "w", encoding="utf-8") as file:
            file.write(HEAD.format(name=name, unsafe=unsafe))


if __name__ == "__main__":
    main()
