#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes the joint recordings of arms/, and tells how near their arms come to the obstacle of their configuration.

    python3 make_arm_motions.py FOLDER     # planar_0.csv ...: two joints of a planar arm; seven_0.csv ...: a Franka arm's seven
"""

import argparse
import os

import numpy as np

PLANAR = {
    "dh": [[0, 0, 0, 0], [0.5, 0, 0, 0]],  # a, alpha, d, theta, modified
    "tip": [0.4, 0, 0],
    "radius": 0.05,
    "ball": ([0.5, 0.68, 0.0], 0.1),
    "start": [-0.5, 0.6],
    "goal": [1.5, 0.5],
    "bend": [0.0, 1.3],
    "spread": 0.08,
}
H = np.pi / 2
SEVEN = {
    "dh": [
        [0, 0, 0.333, 0],
        [0, -H, 0, 0],
        [0, H, 0.316, 0],
        [0.0825, H, 0, 0],
        [-0.0825, -H, 0.384, 0],
        [0, H, 0, 0],
        [0.088, H, 0, 0],
    ],
    "tip": [0, 0, 0.107],
    "radius": 0.06,
    "ball": ([0.6, 0.0, 0.38], 0.08),
    "start": [-0.8, 0.3, 0.1, -1.9, 0.1, 2.2, 0.6],
    "goal": [0.7, 0.3, -0.1, -2.0, -0.1, 2.3, 0.9],
    "bend": [0.0, -0.7, 0.1, -0.55, 0.0, 0.2, 0.0],
    "spread": 0.04,
}


def origins(arm, q):
    """Of the frames and the tip [joints + 2, 3] at joint angles [joints]."""
    turned, origin = np.eye(3), np.zeros(3)
    places = [origin]
    for (a, alpha, d, theta), angle in zip(arm["dh"], q):
        c, s, ca, sa = np.cos(angle + theta), np.sin(angle + theta), np.cos(alpha), np.sin(alpha)
        origin = origin + turned @ [a, -d * sa, d * ca]
        turned = turned @ [[c, -s, 0], [s * ca, c * ca, -sa], [s * sa, c * sa, ca]]
        places.append(origin)
    return np.array([*places, origin + turned @ arm["tip"]])


def clearance(arm, q):
    """The least distance of the arm, capsules between its origins, from its ball along joint angles [M, joints]."""
    center, radius = np.array(arm["ball"][0]), arm["ball"][1]
    least = np.inf
    for row in q:
        places = origins(arm, row)
        for a, b in zip(places[:-1], places[1:]):
            length = (b - a) @ (b - a)
            share = np.clip((center - a) @ (b - a) / length, 0, 1) if length > 0 else 0.0
            least = min(least, np.linalg.norm(a + share * (b - a) - center) - radius - arm["radius"])
    return least


def motion(arm, rng, bend=1.0):
    """Times [M] and joint angles [M, joints]: minimum jerk from a start drawn around the arm's, bent in the middle."""
    times = np.linspace(0.0, 4.0, 81)
    # Not at rest at either end, which no motion x' = f(x) is at the start.
    u = 0.05 + 0.95 * times / 4.0
    s = (u**3 * (10 - 15 * u + 6 * u**2))[:, None]
    goal, offset = np.array(arm["goal"]), rng.uniform(-arm["spread"], arm["spread"], len(arm["goal"]))
    start = np.array(arm["start"]) + offset
    bent = np.array(arm["bend"]) * (1 + rng.uniform(-0.08, 0.08))
    return times, start + s * (goal - start) + bend * np.sin(np.pi * s) * bent


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder")
    folder = parser.parse_args().folder
    os.makedirs(folder, exist_ok=True)
    rng = np.random.default_rng(5)
    for name, arm in (("planar", PLANAR), ("seven", SEVEN)):
        for k in range(5):
            times, q = motion(arm, rng)
            path = os.path.join(folder, f"{name}_{k}.csv")
            header = ",".join(["time", *(f"joint_{j + 1}" for j in range(q.shape[1]))])
            np.savetxt(path, np.column_stack([times, q]), fmt="%.5f", delimiter=",", header=header, comments="")
            print(f"{name}_{k}: {1000 * clearance(arm, q):.0f} mm from the ball")
        straight = clearance(arm, motion({**arm, "spread": 0.0}, rng, bend=0.0)[1])
        print(f"{name}, straight: {1000 * straight:.0f} mm")


if __name__ == "__main__":
    main()
