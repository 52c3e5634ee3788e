#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Motions and obstacles that no one has tuned on: made at random, trained by one default configuration, counted.

Problem k is the same for everyone: it depends on k alone. A motion is a smooth random spline, a spiral, a hook or a
cusp, in two dimensions or (every fifth problem) in three, with three to five demonstrations around it, in metres, far from
the origin. One to four obstacles (balls, boxes, capsules, ellipsoids, polygons) stand around it: anywhere, inside its
bends, beside its start, or in pairs that leave a passage of three times the demonstrations' spread.

A problem counts as solvable when no demonstration comes nearer to an obstacle than its own spread, each obstacle
can be reached from the edge of the workspace without passing the demonstrations (a motion cannot be certified around an
obstacle that it encloses: {B > 0} has no islands), and the motion does not come back to where it has been.

    experiments/random_problems.py --out FOLDER [--first 0] [--count 200] [--jobs 2] [--set KEY=VALUE ...]
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import statistics
import subprocess
import sys
import time

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import label as connected
from scipy.spatial import cKDTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "build/release/experiments/s2nnds"
SAMPLES = 200  # of a demonstration
SPREAD = 0.03  # of the demonstrations around their mean, metres (the motions are about a metre long)
GRID = {2: 241, 3: 49}


def spline(random, n):
    points = random.normal(size=(random.integers(4, 7), n)) * 0.35
    points = np.cumsum(points, axis=0)
    return CubicSpline(np.linspace(0, 1, len(points)), points)(np.linspace(0, 1, SAMPLES))


def spiral(random, n):
    turns = random.uniform(0.6, 1.6) * random.choice([-1, 1])
    s = np.linspace(0, 1, SAMPLES)
    radius, angle = 0.15 + 0.55 * (1 - s), 2 * np.pi * (turns * s + random.uniform())
    path = np.zeros((SAMPLES, n))
    path[:, 0], path[:, 1] = radius * np.cos(angle), radius * np.sin(angle)
    if n == 3:
        path[:, 2] = 0.5 * s
    return path


def hook(random, n):
    s = np.linspace(0, 1, SAMPLES)
    angle = random.uniform(0.8, 1.6) * np.pi * np.clip((s - 0.4) / 0.6, 0, 1)
    heading = random.uniform(0, 2 * np.pi) + angle * random.choice([-1, 1])
    path = np.zeros((SAMPLES, n))
    path[:, 0], path[:, 1] = np.cumsum(np.cos(heading)) / SAMPLES, np.cumsum(np.sin(heading)) / SAMPLES
    if n == 3:
        path[:, 2] = 0.4 * np.sin(2 * s)
    return path


def cusp(random, n):
    corners = np.vstack([np.zeros(n), random.normal(size=n) * 0.6, random.normal(size=n) * 0.6])
    s = np.linspace(0, 2, SAMPLES)
    path = np.stack([np.interp(s, [0, 1, 2], corners[:, k]) for k in range(n)], axis=1)
    kernel = np.hanning(15) / np.hanning(15).sum()
    padded = np.pad(path, ((7, 7), (0, 0)), mode="edge")
    return np.stack([np.convolve(padded[:, k], kernel, "valid") for k in range(n)], axis=1)


MOTIONS = {"spline": spline, "spiral": spiral, "hook": hook, "cusp": cusp}


def arc_length(path):
    """Cumulative length [N] of the path [N, n]."""
    return np.r_[0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]


def evenly(path, count=SAMPLES):
    length = arc_length(path)
    return np.stack([np.interp(np.linspace(0, length[-1], count), length, axis) for axis in path.T], axis=1)


def demonstrations(random, mean, count):
    """Times [N] and positions [N, n] of each: the mean and a smooth deviation that vanishes at the goal."""
    n, result = mean.shape[1], []
    for _ in range(count):
        knots = np.vstack([random.normal(size=(4, n)) * SPREAD / 2, np.zeros(n)])
        deviation = CubicSpline(np.linspace(0, 1, 5), knots)(np.linspace(0, 1, SAMPLES))
        s = np.linspace(0, 1, SAMPLES)
        speed = np.clip(np.minimum(s * 8, (1 - s) * 4), 0.08, 1.0)  # starts and ends slowly
        times = np.r_[0, np.cumsum(1 / speed[:-1])]
        result.append((times / times[-1] * random.uniform(3.0, 5.0), mean + deviation))
    return result


def returns(mean):
    """Whether the path comes back to within four spreads of where it was, another way along."""
    length = arc_length(mean)
    apart = np.abs(length[:, None] - length[None]) > 16 * SPREAD
    near = np.linalg.norm(mean[:, None] - mean[None], axis=2) < 4 * SPREAD
    return bool((apart & near).any())


class Obstacle:
    """A ball or box, turned capsule, ellipsoid or polygon, by its key in a configuration and a distance bound."""

    def __init__(self, random, kind, place, size):
        n = len(place)
        self.kind, place = kind, [round(float(x), 4) for x in place]
        if kind == "ball":
            self.keys = {"type": "ball", "center": place, "radius": round(size, 4)}
        elif kind == "box":
            half = size * random.uniform(0.6, 1.0, n)
            self.keys = {"type": "box", "lower": list(np.round(place - half, 4)), "upper": list(np.round(place + half, 4))}
        elif kind == "ellipsoid":
            self.keys = {"type": "ellipsoid", "center": place, "semi_axes": list(np.round(size * random.uniform(0.5, 1, n), 4))}
        elif kind == "capsule":
            way = random.normal(size=n)
            way *= 0.5 * size / np.linalg.norm(way)
            self.keys = {"type": "capsule", "start": list(np.round(place - way, 4)), "end": list(np.round(place + way, 4)),
                         "radius": round(0.5 * size, 4)}
        else:
            angles = np.sort(random.uniform(0, 2 * np.pi, 5) * 0.3 + np.arange(5) * 2 * np.pi / 5)
            if np.ptp(angles) > 2 * np.pi:  # once around: edges would cross
                angles = np.sort(angles % (2 * np.pi))
            corners = np.stack([np.cos(angles), np.sin(angles)], axis=1) * size * random.uniform(0.7, 1, (5, 1)) + place
            self.keys = {"type": "polygon", "vertices": [list(map(float, c)) for c in np.round(corners, 4)]}

    def contains(self, x):
        """For points [N, n]: bool [N]."""
        k = self.keys
        if self.kind == "ball":
            return np.linalg.norm(x - k["center"], axis=1) <= k["radius"]
        if self.kind == "box":
            return ((x >= k["lower"]) & (x <= k["upper"])).all(axis=1)
        if self.kind == "ellipsoid":
            return (((x - k["center"]) / k["semi_axes"]) ** 2).sum(axis=1) <= 1
        if self.kind == "capsule":
            a, b = np.array(k["start"]), np.array(k["end"])
            t = np.clip(((x - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)
            return np.linalg.norm(x - a - t[:, None] * (b - a), axis=1) <= k["radius"]
        inside = np.zeros(len(x), bool)
        corners = np.array(k["vertices"])
        for p, q in zip(corners, np.roll(corners, -1, axis=0)):
            over = (p[1] > x[:, 1]) != (q[1] > x[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                inside ^= over & (x[:, 0] < (q[0] - p[0]) * (x[:, 1] - p[1]) / (q[1] - p[1]) + p[0])
        return inside

    def toml(self):
        def value(v):
            if isinstance(v, str):
                return f'"{v}"'
            return "[" + ", ".join(map(value, v)) + "]" if isinstance(v, (list, np.ndarray)) else repr(float(v))
        return "{ " + ", ".join(f"{key} = {value(v)}" for key, v in self.keys.items()) + " }"


def places(random, kind, mean, reach):
    """Where obstacles of one layout stand, with their sizes."""
    n = mean.shape[1]
    across = random.normal(size=(4, n))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    at = mean[random.integers(20, SAMPLES - 40, 4)]
    if kind == "start":
        return [(mean[0] + across[0] * random.uniform(4, 6) * SPREAD, 2 * SPREAD)]
    if kind == "passage":
        way = mean[len(mean) // 2 + 1] - mean[len(mean) // 2]
        side = across[0] - across[0] @ way / (way @ way) * way
        side *= (1.5 * SPREAD + 2.5 * SPREAD) / np.linalg.norm(side)
        return [(mean[len(mean) // 2] + side, 2 * SPREAD), (mean[len(mean) // 2] - side, 2 * SPREAD)]
    if kind == "bend":
        centre = mean[40:160].mean(axis=0)
        return [(centre, random.uniform(1.5, 3.5) * SPREAD)]
    return [(at[i] + across[i] * random.uniform(3, 10) * SPREAD, random.uniform(1, 3) * SPREAD)
            for i in range(random.integers(1, 5))]


def enclosed(obstacles, demos, lower, upper):
    """Whether some part of an obstacle cannot be joined to the workspace's edge without passing a demonstration."""
    n = len(lower)
    axes = [np.linspace(lower[k], upper[k], GRID[n]) for k in range(n)]
    x = np.stack([a.ravel() for a in np.meshgrid(*axes, indexing="ij")], axis=1)
    taken = np.zeros(len(x), bool)
    paths = np.vstack([evenly(p) for _, p in demos])
    width = 1.5 * max((upper - lower) / GRID[n])
    taken = cKDTree(paths).query(x)[0] < width
    free = connected(~taken.reshape([GRID[n]] * n))[0].ravel()
    edge = np.unique(free[((x == lower) | (x == upper)).any(axis=1)])
    in_some = np.any([o.contains(x) for o in obstacles], axis=0)
    return bool((~np.isin(free[in_some], edge)).any())


def problem(k):
    """Problem k: its demonstrations, obstacles, kinds and label."""
    random = np.random.default_rng([20260, k])
    n = 3 if k % 5 == 4 else 2
    motion = list(MOTIONS)[k % 4 if n == 2 else random.integers(4)]
    layout = ["anywhere", "bend", "start", "passage"][(k // 4) % 4]
    mean = evenly(MOTIONS[motion](random, n))
    mean /= np.ptp(mean, axis=0).max()  # a metre
    demos = demonstrations(random, mean, int(random.integers(3, 6)))
    kinds = ["ball", "box", "ellipsoid", "capsule"] + (["polygon"] if n == 2 else [])
    lower, upper = mean.min(axis=0) - 0.25, mean.max(axis=0) + 0.25
    near = np.vstack([p for _, p in demos])
    obstacles = []
    for place, size in places(random, layout, mean, upper - lower):
        size = min(size, np.linalg.norm(mean[-1] - place) - 2 * SPREAD)  # not on the goal
        if size < 0.5 * SPREAD:
            continue
        obstacles.append(Obstacle(random, str(random.choice(kinds)), np.array(place), size))
    margin = np.vstack([near + d for d in SPREAD * np.vstack([np.zeros(n), np.eye(n), -np.eye(n)])])
    why = ""
    if not obstacles:
        why = "no obstacle"
    elif returns(mean):
        why = "comes back to where it was"
    elif any(o.contains(margin).any() for o in obstacles):
        why = "obstacle on the way"
    elif n == 2 and enclosed(obstacles, demos, lower, upper):
        why = "obstacle enclosed"
    shift = random.uniform(-2, 2, n)
    return {"n": n, "motion": motion, "layout": layout, "why": why, "shift": shift, "obstacles": obstacles,
            "demos": [(t, p) for t, p in demos], "bounds": (lower, upper)}


def write(folder, k):
    """The problem's recordings and configuration, positions moved away from the origin. Returns its description."""
    made = problem(k)
    home = folder / f"{k:03}"
    home.mkdir(parents=True, exist_ok=True)
    shift = np.round(made["shift"], 2)
    for i, (t, p) in enumerate(made["demos"]):
        np.savetxt(home / f"{i}.csv", np.c_[t, p + shift], delimiter=",", fmt="%.6f", comments="",
                   header=",".join(["time", "x", "y", "z"][: made["n"] + 1]))
    for o in made["obstacles"]:
        for key in ("center", "lower", "upper", "start", "end"):
            if key in o.keys:
                o.keys[key] = list(np.round(np.array(o.keys[key]) + shift, 4))
        if "vertices" in o.keys:
            o.keys["vertices"] = [list(np.round(np.array(q) + shift, 4)) for q in o.keys["vertices"]]
    texts = [o.toml() for o in made["obstacles"]]
    unsafe = texts[0] if len(texts) == 1 else '{ type = "union", of = [' + ", ".join(texts) + "] }"
    if not texts:
        unsafe = '{ type = "none" }'
    lower, upper = (list(np.round(b + shift, 4)) for b in made["bounds"])
    (home / "problem.toml").write_text(
        f'name = "random-{k:03}"\n[data]\nsource = "csv"\nfiles = ["*.csv"]\nunit = "m"\ntest = []\n\n[problem]\n'
        f"bounds = {{ lower = {[float(v) for v in lower]}, upper = {[float(v) for v in upper]} }}\nunsafe = {unsafe}\n")
    return made


def train(folder, k, settings, program, until):
    made = write(folder, k)
    home = folder / f"{k:03}"
    row = {"problem": k, "dimension": made["n"], "motion": made["motion"], "layout": made["layout"], "unsolvable": made["why"]}
    begin = time.monotonic()
    command = [program, "train", "problem.toml", "--data", ".", "--out", "run.h5", "--threads", "1", "--json", "--until", until]
    for each in settings:
        command += ["--set", each]
    done = subprocess.run(command, cwd=home, capture_output=True, text=True)
    (home / "log.txt").write_text(done.stderr + done.stdout)
    row.update(code=done.returncode, seconds=round(time.monotonic() - begin, 1))
    if done.returncode == 2:
        row["said"] = done.stderr.strip().splitlines()[-1]
        return row
    try:
        found = json.loads(done.stdout.strip().splitlines()[-1])
    except (ValueError, IndexError):
        row["said"] = (done.stderr.strip().splitlines() or ["nothing"])[-1]
        return row
    row.update(guarantee=found["guarantee"], dtw_train=found["dtw_train"], rounds=found["rounds"],
               training=found["seconds"].get("training"), first=found["seconds"].get("first_clean_round"),
               follows=found.get("follows"), area=found.get("safe_area_ratio"), said=" ".join(found.get("remarks", [])))
    return row


def is_solved(row):
    return row.get("guarantee") == "invariant" and row.get("follows", True) and row["dtw_train"] <= 0.1 and row["code"] == 0


def table(rows):
    """Lines of a table by kind of motion and layout."""
    lines = ["| | solvable | solved | median s | longest s | first certificate s |", "|---|---|---|---|---|---|"]
    groups = [("all", rows)] + [(f"{d}-D", [r for r in rows if r["dimension"] == d]) for d in (2, 3)]
    groups += [(m, [r for r in rows if r["motion"] == m]) for m in MOTIONS]
    groups += [(w, [r for r in rows if r["layout"] == w]) for w in ("anywhere", "bend", "start", "passage")]
    for name, group in groups:
        able = [r for r in group if not r["unsolvable"]]
        if not able:
            continue
        first = [r["first"] for r in able if r.get("first")]
        seconds = [r["seconds"] for r in able]
        lines.append(f"| {name} | {len(able)} | {sum(map(is_solved, able))} | {statistics.median(seconds):.1f} | {max(seconds):.0f} | "
                     f"{statistics.median(first) if first else float('nan'):.1f} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder of recordings, runs and results.json")
    parser.add_argument("--first", type=int, default=0, help="number of the first problem")
    parser.add_argument("--count", type=int, default=200, help="how many problems")
    parser.add_argument("--jobs", type=int, default=2, help="trainings at a time, one thread each")
    parser.add_argument("--program", default=str(PROGRAM), help="the program s2nnds")
    parser.add_argument("--all", action="store_true", help="train those that count as unsolvable, too")
    parser.add_argument("--until", default="finished", choices=["certified", "finished"], help="as of `s2nnds train`")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="of every configuration")
    arguments = parser.parse_args()
    chosen = [k for k in range(arguments.first, arguments.first + arguments.count)
              if arguments.all or not problem(k)["why"]]
    rows = []
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for row in pool.map(lambda k: train(arguments.out, k, arguments.set, arguments.program, arguments.until), chosen):
            rows.append(row)
            print(json.dumps(row), flush=True)
            (arguments.out / "results.json").write_text(json.dumps(rows, indent=1))
    print(f"{arguments.count - len(chosen)} of {arguments.count} problems count as unsolvable and were left out"
          if not arguments.all else "", *table(rows), sep="\n")


if __name__ == "__main__":
    sys.exit(main())
