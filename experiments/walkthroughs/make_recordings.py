# SPDX-License-Identifier: BSD-3-Clause
"""Synthetic recordings in the formats of four kinds of robot, for the walk-throughs of README.md in this folder.

    python3 make_recordings.py arm FOLDER       # reach_0.csv ...: a 7-joint arm led by hand; joints, position [m], quaternion;
                                                # bottle.obj and bottle.xyz: a bottle as a mesh and as a scan
    python3 make_recordings.py pour FOLDER      # pour_0.csv ...: a cup brought back upright; position [m], quaternion (../poses)
    python3 make_recordings.py joints FOLDER    # reach_0.csv ...: 4 joints [rad], the first one wrapped to (-pi, pi]
    python3 make_recordings.py mobile FOLDER    # drive_0.bag ... (ROS 1), room.pgm and room.yaml: a robot that drives past a shelf
    python3 make_recordings.py lerobot FOLDER   # a LeRobot v3 data set: a planar arm that places a part

The kind mobile needs the Python package rosbags, lerobot pyarrow.
"""

import argparse
import json
import os
import sys

import numpy as np


def minimum_jerk(s):
    return s**3 * (10 - 15 * s + 6 * s**2)


def motion(start, goal, bend, seconds, rate, rng, noise=0.0, rest=0.0):
    """Times [M] and positions [M, n] of a move that bends by the vector `bend` in its middle, with rest before and after."""
    times = np.arange(0.0, seconds + 2 * rest, 1 / rate)
    s = minimum_jerk(np.clip((times - rest) / seconds, 0.0, 1.0))[:, None]
    start, goal, bend = (np.asarray(v, dtype=float) for v in (start, goal, bend))
    position = start + s * (goal - start) + np.sin(np.pi * s) * bend
    return times, position + noise * rng.standard_normal(position.shape)


def arm(folder, rng):
    for k in range(5):
        start = [0.35, -0.32, 0.42] + rng.uniform(-0.03, 0.03, 3)
        times, position = motion(start, [0.55, 0.25, 0.12], [0.02, 0.0, 0.16], 3.5, 50, rng, noise=2e-4, rest=0.6)
        goal_end = position[-1]
        joints = np.column_stack([0.3 * j + (position - goal_end) @ rng.uniform(-1, 1, 3) for j in range(7)])
        half = 0.5 * (np.pi + 0.6 * position[:, 1])  # turned about x, hand down
        quaternion = np.column_stack([np.sin(half), 0 * half, 0 * half, np.cos(half)])
        quaternion[len(half) // 2 :] *= -1  # some drivers jump between q and -q
        names = ["time", *(f"joint_{j + 1}" for j in range(7)), "x", "y", "z", "qx", "qy", "qz", "qw"]
        table = np.column_stack([times, joints, position, quaternion])
        np.savetxt(f"{folder}/reach_{k}.csv", table, fmt="%.5f", delimiter=",", header=",".join(names), comments="")
    write_bottle(folder, rng)


BOTTLE = ((0.05, -0.05), (0.05, 0.12), (0.018, 0.16), (0.018, 0.2))  # radius and height of its rings [m]
BOTTLE_AT = (0.45, -0.03)


def write_bottle(folder, rng, sides=24):
    """A closed mesh, and 1,500 points of its side as a depth camera sees them."""
    angles = 2 * np.pi * np.arange(sides) / sides
    around = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [np.column_stack([BOTTLE_AT + r * around, np.full(sides, z)]) for r, z in BOTTLE]
    corners = np.vstack([*rings, [*BOTTLE_AT, BOTTLE[0][1]], [*BOTTLE_AT, BOTTLE[-1][1]]])
    bottom, top, last = len(corners) - 2, len(corners) - 1, (len(rings) - 1) * sides
    triangles = []
    for i in range(sides):
        j = (i + 1) % sides
        triangles += [(bottom, j, i), (top, last + i, last + j)]
        for low in range(0, last, sides):
            triangles += [(low + i, low + j, low + sides + j), (low + i, low + sides + j, low + sides + i)]
    with open(f"{folder}/bottle.obj", "w", encoding="utf-8") as file:
        file.writelines(f"v {x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in corners)
        file.writelines(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in triangles)
    heights = rng.uniform(BOTTLE[0][1], BOTTLE[-1][1], 1500)
    radii = np.interp(heights, *np.array(BOTTLE)[:, ::-1].T)
    angles = rng.uniform(0, 2 * np.pi, 1500)
    points = np.column_stack([BOTTLE_AT + radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]), heights])
    np.savetxt(f"{folder}/bottle.xyz", points + 1e-3 * rng.standard_normal(points.shape), fmt="%.5f")


def quaternion(r):
    """(w, x, y, z) [M, 4] of rotation vectors [M, 3]."""
    angle = np.linalg.norm(r, axis=1, keepdims=True)
    return np.hstack([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * r])


def product(a, b):
    """Of quaternions (w, x, y, z) [M, 4]."""
    w = a[:, :1] * b[:, :1] - np.sum(a[:, 1:] * b[:, 1:], axis=1, keepdims=True)
    return np.hstack([w, a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])])


def pour(folder, rng):
    """Over an arc from one side to the other; the cup is tilted and turned at first and comes to stand as the hand holds it."""
    for k in range(5):
        start = [0.40, -0.30, 0.35] + rng.uniform(-0.03, 0.03, 3)
        times, position = motion(start, [0.55, 0.20, 0.15], [-0.03, 0.0, 0.14], 4.0, 25, rng, noise=1e-4)
        s = minimum_jerk(times / 4.0)[:, None]
        tilt = np.array([1.2, 0.0, 0.0]) + rng.uniform(-0.06, 0.06, 3)
        turn = np.array([0.0, 0.5, 0.8]) + rng.uniform(-0.05, 0.05, 3)
        r = (1 - s) * tilt + np.sin(np.pi * s) * turn + 2e-3 * rng.standard_normal((len(s), 3))
        goal = np.tile([0.0, 0.9238795, 0.3826834, 0.0], (len(s), 1))  # hand down, turned by 45 degrees
        q = product(goal, quaternion(r))[:, [1, 2, 3, 0]]
        q[len(q) // 3 :] *= -1  # some drivers jump between q and -q
        table = np.column_stack([times, position, q])
        np.savetxt(f"{folder}/pour_{k}.csv", table, fmt="%.5f", delimiter=",", header="time,x,y,z,qx,qy,qz,qw", comments="")


def joints(folder, rng):
    for k in range(5):
        start = [2.9, -0.6, 1.4, -0.5] + rng.uniform(-0.08, 0.08, 4)
        times, angle = motion(start, [3.7, 0.5, 0.6, 0.4], [0.1, 0.25, 0.2, -0.1], 4.0, 25, rng, noise=3e-4)
        angle = np.mod(angle + np.pi, 2 * np.pi) - np.pi  # as an encoder tells them
        names = ["time", *(f"joint_{j + 1}" for j in range(4))]
        table = np.column_stack([times, angle])
        np.savetxt(f"{folder}/reach_{k}.csv", table, fmt="%.5f", delimiter=",", header=",".join(names), comments="")


def room():
    """An occupancy image of 6 m by 4 m, 5 cm a cell, rows from the top: walls around, a shelf from the lower wall."""
    free = np.full((80, 120), 254, dtype=np.uint8)
    free[[0, 1, -2, -1], :] = 0
    free[:, [0, 1, -2, -1]] = 0
    free[44:78, 56:64] = 0  # x 2.8 to 3.2 m, y 0.1 to 1.8 m
    return free


def write_map(folder):
    image = room()
    with open(f"{folder}/room.pgm", "wb") as file:
        file.write(b"P5\n%d %d\n255\n" % (image.shape[1], image.shape[0]) + image.tobytes())
    with open(f"{folder}/room.yaml", "w", encoding="utf-8") as file:
        file.write("image: room.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")


def mobile(folder, rng):
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    write_map(folder)
    store = get_typestore(Stores.ROS1_NOETIC)
    names = "PoseStamped Pose Point Quaternion".split()
    stamped, pose, point, quaternion = (store.types[f"geometry_msgs/msg/{name}"] for name in names)
    header, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    for k in range(5):
        path = f"{folder}/drive_{k}.bag"
        if os.path.exists(path):
            os.remove(path)
        start = [1.2, 1.0] + rng.uniform(-0.12, 0.12, 2)
        times, position = motion(start, [4.8, 1.0], [0.0, 1.7], 9.0, 20, rng, noise=1e-3, rest=1.0)
        velocity = np.gradient(position, times, axis=0)
        moving = np.flatnonzero(np.linalg.norm(velocity, axis=1) > 0.1)  # at rest a robot keeps its heading
        heading = np.interp(np.arange(len(times)), moving, np.unwrap(np.arctan2(velocity[moving, 1], velocity[moving, 0])))
        with Writer(path) as bag:
            connection = bag.add_connection("/robot_pose", stamped.__msgtype__, typestore=store)
            for i, (t, (x, y), angle) in enumerate(zip(times, position, heading)):
                stamp = 1_700_000_000_000_000_000 + k * 60_000_000_000 + int(t * 1e9)
                turned = quaternion(0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2))
                message = stamped(
                    header(i, time(stamp // 10**9, stamp % 10**9), "map"), pose(point(x, y, 0.0), turned)
                )
                late = stamp + int(rng.uniform(1e6, 8e6))  # messages are recorded a little later than they are made
                bag.write(connection, late, store.serialize_ros1(message, stamped.__msgtype__))


def lerobot(folder, rng):
    import pyarrow
    import pyarrow.parquet

    fps, rows = 30, {"observation.state": [], "timestamp": [], "frame_index": [], "episode_index": [], "index": [], "task_index": []}
    for k in range(6):
        start = [0.12, 0.38] + rng.uniform(-0.02, 0.02, 2)
        times, position = motion(start, [0.42, 0.16], [0.09, 0.1], 2.5, fps, rng, noise=1e-4, rest=0.5)
        grip = (times > 2.9).astype(float)
        for i, (t, p, g) in enumerate(zip(times, position, grip)):
            values = ([*p.tolist(), float(g)], t, i, k, len(rows["index"]), 0)
            for name, value in zip(rows, values):
                rows[name].append(value)
    types = {"observation.state": pyarrow.list_(pyarrow.float32(), 3), "timestamp": pyarrow.float32()}
    table = pyarrow.table({name: pyarrow.array(values, types.get(name, pyarrow.int64())) for name, values in rows.items()})
    os.makedirs(f"{folder}/data/chunk-000", exist_ok=True)
    os.makedirs(f"{folder}/meta", exist_ok=True)
    pyarrow.parquet.write_table(table, f"{folder}/data/chunk-000/file-000.parquet")
    scalar = {name: {"dtype": "int64", "shape": [1], "names": None} for name in ("frame_index", "episode_index", "index", "task_index")}
    info = {
        "codebase_version": "v3.0",
        "robot_type": "planar_arm",
        "total_episodes": 6,
        "total_frames": len(rows["index"]),
        "fps": fps,
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "features": {
            "observation.state": {"dtype": "float32", "shape": [3], "names": ["x", "y", "gripper"]},
            "timestamp": {"dtype": "float32", "shape": [1], "names": None},
            **scalar,
        },
    }
    with open(f"{folder}/meta/info.json", "w", encoding="utf-8") as file:
        json.dump(info, file, indent=2)


def main():
    kinds = {"arm": arm, "pour": pour, "joints": joints, "mobile": mobile, "lerobot": lerobot}
    parser = argparse.ArgumentParser(description="Synthetic recordings for the walk-throughs.")
    parser.add_argument("kind", choices=kinds)
    parser.add_argument("folder")
    options = parser.parse_args()
    os.makedirs(options.folder, exist_ok=True)
    try:
        kinds[options.kind](options.folder, np.random.default_rng(7))
    except ModuleNotFoundError as error:
        print(f"make_recordings: {error}; pip install {error.name.split('.')[0]}", file=sys.stderr)
        return 77
    return 0


if __name__ == "__main__":
    sys.exit(main())
