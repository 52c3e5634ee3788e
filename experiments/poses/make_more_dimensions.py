#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes test problems, recordings and configuration each: in four dimensions four motions of four joints, and four planar
motions of second order as states (position, velocity); and a motion of two, three, four and five joints.

    python3 make_more_dimensions.py FOLDER     # FOLDER/joints_1/config.toml ... FOLDER/second_order_4/config.toml,
                                               # FOLDER/growth_2/config.toml ... FOLDER/growth_5/config.toml
"""

import argparse
import os

import numpy as np
from scipy.integrate import solve_ivp

# Start, goal, bend in the middle [rad], obstacle.
JOINTS = {
    "joints_1": ([-0.6, 0.4, -0.5, 0.3], [0.2, -0.2, 0.3, -0.3], [0.0, 0.0, 0.0, 0.0], None),
    "joints_2": ([-0.8, -0.5, 0.4, 0.3], [0.3, 0.2, -0.3, -0.4], [0.1, 0.25, 0.2, -0.1], None),
    "joints_3": (
        [-0.6, 0.4, -0.5, 0.3],
        [0.2, -0.2, 0.3, -0.3],
        [0.1, 0.1, 0.0, 0.1],
        '{ type = "ball", center = [-0.4, -0.3, -0.2, -0.2], radius = 0.15 }',
    ),
    "joints_4": (
        [-0.8, -0.5, 0.4, 0.3],
        [0.3, 0.2, -0.3, -0.4],
        [0.15, 0.3, 0.0, -0.2],
        '{ type = "ball", center = [-0.2, -0.5, 0.0, 0.3], radius = 0.2 }',
    ),
}

# Start, goal and bend of a motion of as many joints as are taken of them [rad].
GROWTH = ([-0.8, -0.5, 0.4, 0.3, -0.4], [0.3, 0.2, -0.3, -0.4, 0.2], [0.1, 0.25, 0.2, -0.1, 0.1])

# x'' = -stiffness x - damping v + turn (v_2, -v_1) + bend x x', in m and s, and an obstacle in (x, v).
SECOND_ORDER = {
    "second_order_1": (1.0, 2.0, 0.0, 0.0, None),
    "second_order_2": (2.0, 2.0, 0.8, 0.0, None),
    "second_order_3": (1.5, 2.2, 0.5, 0.6, None),
    "second_order_4": (
        1.0,
        2.0,
        0.6,
        0.0,
        '{ type = "box", lower = [-0.9, 0.75, -inf, -inf], upper = [-0.4, 1.1, inf, inf] }',
    ),
}


JOINT_KEYS = 'state = "joints"\nunit = "rad"\n'


def joint_names(count):
    return ["time", *(f"joint_{j + 1}" for j in range(count))]


def minimum_jerk(s):
    return s**3 * (10 - 15 * s + 6 * s**2)


def write(folder, names, tables, config):
    os.makedirs(folder, exist_ok=True)
    for k, table in enumerate(tables):
        np.savetxt(os.path.join(folder, f"d{k}.csv"), table, fmt="%.6f", delimiter=",", header=",".join(names), comments="")
    with open(os.path.join(folder, "config.toml"), "w", encoding="utf-8") as file:
        file.write(config)


def joint_motion(start, goal, bend, rng):
    times = np.linspace(0.0, 4.0, 101)
    # Not at rest at either end, which no motion x' = f(x) is at the start.
    s = np.clip(minimum_jerk(0.05 + 0.95 * times / 4.0), 0.0, 1.0)[:, None]
    start = np.asarray(start) + rng.uniform(-0.05, 0.05, len(start))
    return np.column_stack([times, start + s * (np.asarray(goal) - start) + np.sin(np.pi * s) * np.asarray(bend)])


def second_order_motion(stiffness, damping, turn, bend, rng):
    def change(_, state):
        x, v = state[:2], state[2:]
        return np.concatenate([v, -stiffness * x - damping * v + turn * np.array([v[1], -v[0]]) + bend * x[::-1] * v])

    times = np.linspace(0.0, 7.0, 141)
    start = np.concatenate([[-1.0, 0.5] + rng.uniform(-0.06, 0.06, 2), [0.0, 0.0]])
    state = solve_ivp(change, (0.0, 7.0), start, t_eval=times, rtol=1e-8, atol=1e-10).y.T
    return np.column_stack([times, state, [change(0.0, row) for row in state]])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder")
    folder = parser.parse_args().folder
    rng = np.random.default_rng(11)
    head = 'name = "{}"\nprofile = "smooth"\n\n[data]\nsource = "csv"\nfiles = ["d*.csv"]\n{}\n[problem]\n{}'
    for name, (start, goal, bend, obstacle) in JOINTS.items():
        unsafe = f"unsafe = {obstacle}\n" if obstacle else ""
        write(
            os.path.join(folder, name),
            joint_names(4),
            [joint_motion(start, goal, bend, rng) for _ in range(5)],
            head.format(name, JOINT_KEYS, unsafe),
        )
    columns = 'columns = { position = ["x", "y", "vx", "vy"], velocity = ["dx", "dy", "ax", "ay"] }\n'
    for name, (*law, obstacle) in SECOND_ORDER.items():
        unsafe = f"unsafe = {obstacle}\n" if obstacle else ""
        write(
            os.path.join(folder, name),
            ["time", "x", "y", "vx", "vy", "dx", "dy", "ax", "ay"],
            [second_order_motion(*law, rng) for _ in range(5)],
            head.format(name, columns, unsafe),
        )
    for joints in range(2, 6):
        motion = [numbers[:joints] for numbers in GROWTH]
        write(
            os.path.join(folder, f"growth_{joints}"),
            joint_names(joints),
            [joint_motion(*motion, rng) for _ in range(5)],
            head.format(f"growth_{joints}", JOINT_KEYS, ""),
        )


if __name__ == "__main__":
    main()
