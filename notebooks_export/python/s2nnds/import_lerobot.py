# SPDX-License-Identifier: BSD-3-Clause
"""LeRobot data sets, version 3 (and 2): Parquet tables of frames below data/, described by meta/info.json (package pyarrow)."""

import glob
import json
import os

import numpy as np

from .imported_recording import ImportRefused, Recording, package

DEFAULT_COLUMN = "observation.state"


def _info(source):
    path = os.path.join(source, "meta", "info.json")
    try:
        with open(path, encoding="utf-8") as file:
            info = json.load(file)
    except ValueError as error:
        raise ImportRefused(f"{path}: cannot be read as JSON: {error}") from None
    version = str(info.get("codebase_version", ""))
    if not version.startswith(("v3", "v2")):
        raise ImportRefused(f"{path}: found a data set of version '{version}'; expected v3 or v2")
    return info


def _names(feature, count):
    """The names of a vector's entries: a list, or a list in a table {"motors": [...]}; else x1, x2, ..."""
    names = feature.get("names")
    if isinstance(names, dict):
        names = next(iter(names.values()), None)
    if isinstance(names, list) and len(names) == count and all(isinstance(name, str) for name in names):
        return names
    return [f"x{k + 1}" for k in range(count)]


def _frames(source, column):
    """Columns of all frames, in the order of the files."""
    parquet = package("pyarrow.parquet", "import of LeRobot data sets")
    files = sorted(glob.glob(os.path.join(glob.escape(source), "data", "**", "*.parquet"), recursive=True))
    if not files:
        raise ImportRefused(f"{source}: found no Parquet files in data/; expected data/chunk-000/file-000.parquet")
    parts = []
    for path in files:
        try:
            parts.append(parquet.read_table(path, columns=["episode_index", "timestamp", column]).to_pydict())
        except Exception as error:  # pyarrow raises errors of many kinds for a damaged file
            text = " ".join(str(error).split())
            raise ImportRefused(f"{path}: cannot be read as a Parquet table with {column}: {text[:200]}") from None
    return {name: [value for part in parts for value in part[name]] for name in ("episode_index", "timestamp", column)}


def _position_names(names):
    """Without a wish: x, y, z where there are such; else all but the gripper."""
    ends = [name.lower().split(".")[-1].split("_")[-1] for name in names]
    if {"x", "y"} <= set(ends):
        return [name for name, end in zip(names, ends) if end in ("x", "y", "z")][:3]
    return [name for name in names if "gripper" not in name.lower()]


def read_lerobot(source, options):
    """One demonstration an episode. No such data set says its unit."""
    info = _info(source)
    features = info.get("features", {})
    column = options.column or DEFAULT_COLUMN
    if column not in features:
        vectors = [name for name, about in features.items() if len(about.get("shape", [])) == 1 and about.get("dtype", "").startswith("float")]
        raise ImportRefused(f"{source}: found no column '{column}'; expected --column to name one of {', '.join(vectors)}")
    table = _frames(source, column)
    try:
        values = np.array(table[column], dtype=float)
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.ndim != 2:
        raise ImportRefused(f"{source}: {column}: found entries that are not vectors of one length; expected [frames, n]")
    episodes, times = np.array(table["episode_index"]), np.array(table["timestamp"], dtype=float)
    names = _names(features[column], values.shape[1])
    keep = names if options.coordinates else _position_names(names)
    places = [names.index(name) for name in keep]
    there = list(dict.fromkeys(episodes.tolist()))
    wanted = options.episodes if options.episodes is not None else there
    left_out = ", ".join(name for name in names if name not in keep)
    recordings = []
    for episode in wanted:
        rows = np.flatnonzero(episodes == episode)
        if len(rows) < 2:
            raise ImportRefused(f"{source}: found {len(rows)} frames of episode {episode}; expected 2 or more (episodes {there[0]} to {there[-1]})")
        origin = {"column": column, "type": f"LeRobot {info['codebase_version']}", "episode": int(episode), "fps": float(info.get("fps", 0))}
        if left_out:
            origin["notes"] = f"without {left_out}"
        recordings.append(Recording(source, times[rows], values[np.ix_(rows, places)], keep, "", "", None, None, origin))
    return recordings
