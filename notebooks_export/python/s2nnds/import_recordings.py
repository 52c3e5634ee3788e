# SPDX-License-Identifier: BSD-3-Clause
"""Recordings of others as demonstrations in HDF5 (data.source = "hdf5"), with their origin.

    s2nnds import SOURCE... --out demonstrations.h5

A SOURCE is a ROS 1 bag (.bag), a ROS 2 bag (its folder), an MCAP file (.mcap) or a LeRobot data set (its folder).
The packages that read them are optional: pip install rosbags mcap pyarrow.
The file has, for every demonstration K, /demonstrations/K/time [M] in s from its start, position [M, n] and, where they
were recorded, velocity [M, n] and orientation [M, 4] (quaternions x, y, z, w of one sign). Attributes of
/demonstrations: unit, frame, coordinates; of /demonstrations/K: source, sha256, topic or column, type, start_time.
"""

import argparse
import hashlib
import os
import sys

import h5py
import numpy as np

from .imported_recording import ImportRefused, Recording


def chosen(names, wanted, where):
    """The places of the coordinates `wanted` among `names`; a coordinate is a name or a number from 0."""
    places = []
    for word in wanted:
        if word in names:
            places.append(names.index(word))
        elif word.isdigit() and int(word) < len(names):
            places.append(int(word))
        else:
            raise ImportRefused(f"{where}: found no coordinate '{word}'; expected some of {', '.join(names)}")
    return places


def one_sign(quaternions):
    """q and -q are one orientation: neighbours get the sign under which they lie closest."""
    same = np.sum(quaternions[1:] * quaternions[:-1], axis=1) >= 0.0
    signs = np.cumprod(np.concatenate([[1.0], np.where(same, 1.0, -1.0)]))
    return quaternions * signs[:, None]


def unmoving(recordings):
    """Coordinates that have one value in all recordings: those of a planar motion in space."""
    all_positions = np.concatenate([r.position for r in recordings])
    return np.ptp(all_positions, axis=0) == 0.0 if np.isfinite(all_positions).all() else np.zeros(all_positions.shape[1], bool)


def with_coordinates(recordings, wanted):
    """The recordings with these coordinates; without a wish, with all that move. Also what was left out."""
    names = recordings[0].coordinates
    for r in recordings:
        if r.coordinates != names:
            raise ImportRefused(
                f"{r.source}: found the coordinates {', '.join(r.coordinates)}; expected {', '.join(names)} as in {recordings[0].source}"
            )
    if wanted:
        places = chosen(names, wanted, recordings[0].source)
    else:
        still = unmoving(recordings)
        places = [k for k in range(len(names)) if not still[k]]
    if len(places) < 2:
        raise ImportRefused(
            f"{recordings[0].source}: found {len(places)} coordinate(s) that move; expected 2 or more of {', '.join(names)}"
        )
    for r in recordings:
        r.position = r.position[:, places]
        r.velocity = None if r.velocity is None else r.velocity[:, places]
        r.coordinates = [names[k] for k in places]
    return [name for k, name in enumerate(names) if k not in places]


def split_at_gaps(recording, longest):
    """Parts without a step of time longer than `longest` seconds; 0: the recording as it is."""
    steps = np.diff(recording.time)
    ends = np.flatnonzero(steps > longest) + 1 if longest > 0 else []
    parts = []
    for part in np.split(np.arange(len(recording.time)), ends):
        if len(part) < 2:
            continue
        pick = lambda values: None if values is None else values[part]  # noqa: E731
        parts.append(
            Recording(
                recording.source,
                recording.time[part],
                recording.position[part],
                recording.coordinates,
                recording.unit,
                recording.frame,
                pick(recording.velocity),
                pick(recording.orientation),
                dict(recording.origin, start_time=recording.origin.get("start_time", 0.0) + float(recording.time[part[0]] - recording.time[0])),
            )
        )
    return parts


def digest(path):
    """SHA-256 of a file, or of the names and bytes of all files of a folder."""
    total = hashlib.sha256()
    files = [path]
    if os.path.isdir(path):
        files = sorted(os.path.join(folder, name) for folder, _, names in os.walk(path) for name in names)
    for name in files:
        if os.path.isdir(path):
            total.update(os.path.relpath(name, path).encode() + b"\0")
        with open(name, "rb") as file:
            while block := file.read(1 << 20):
                total.update(block)
    return total.hexdigest()


def write(path, recordings):
    """Written beside its place and renamed, so that a crash leaves the old file or the new one."""
    hashes = {source: digest(source) for source in {r.source for r in recordings}}
    part = f"{path}.part"
    with h5py.File(part, "w", track_order=True) as file:
        group = file.create_group("demonstrations", track_order=True)
        group.attrs["unit"] = recordings[0].unit
        group.attrs["frame"] = recordings[0].frame
        group.attrs["coordinates"] = recordings[0].coordinates
        for k, r in enumerate(recordings):
            item = group.create_group(str(k))
            item["time"] = r.time - r.time[0]
            item["position"] = r.position
            if r.velocity is not None:
                item["velocity"] = r.velocity
            if r.orientation is not None:
                item["orientation"] = one_sign(r.orientation)
            item.attrs.update({"source": r.source, "sha256": hashes[r.source], **r.origin})
    os.replace(part, path)


def read(source, options):
    """The recordings of one source, by what it is."""
    if not os.path.exists(source):
        raise ImportRefused(f"{source}: found no such file or folder; expected a recording")
    if os.path.isfile(os.path.join(source, "meta", "info.json")):
        from .import_lerobot import read_lerobot

        return read_lerobot(source, options)
    if source.endswith((".bag", ".mcap")) or os.path.isfile(os.path.join(source, "metadata.yaml")):
        from .import_ros import read_ros

        return read_ros(source, options)
    raise ImportRefused(
        f"{source}: found neither a ROS 1 bag (.bag), a ROS 2 bag (a folder with metadata.yaml), an MCAP file (.mcap) nor a "
        "LeRobot data set (a folder with meta/info.json); CSV, NPY, MATLAB and HDF5 files are read without import"
    )


def check(recordings):
    if not recordings:
        raise ImportRefused("import: found no demonstration with 2 samples or more; expected one")
    for what in ("unit", "frame"):
        values = sorted({getattr(r, what) for r in recordings})
        if len(values) > 1:
            raise ImportRefused(f"import: found positions in the {what}s {', '.join(values)}; expected one (import them apart)")


def arguments_of(words):
    class Parser(argparse.ArgumentParser):
        def error(self, message):
            raise ImportRefused(f"import: {message}")

    parser = Parser(
        prog="s2nnds import",
        description="Recordings of others (ROS 1 and 2 bags, MCAP, LeRobot) as demonstrations in HDF5.",
    )
    parser.add_argument("sources", nargs="+", help="bags, MCAP files, or folders of LeRobot data sets")
    parser.add_argument("--out", required=True, help="HDF5 file to write")
    parser.add_argument("--topic", default="", help="ROS: the topic, where a bag has several that hold positions")
    parser.add_argument("--child", default="", help="ROS, topic /tf: the frame whose transform is taken")
    parser.add_argument(
        "--time", default="auto", choices=("auto", "header", "received"),
        help="ROS: stamps of the messages' headers, or when they were received; auto: the headers' where they have any",
    )
    parser.add_argument("--column", default="", help="LeRobot: the column of the positions (default observation.state)")
    parser.add_argument("--episodes", nargs="+", type=int, help="LeRobot: which episodes (default: all)")
    parser.add_argument("--coordinates", nargs="+", help="which coordinates, by name or number from 0 (default: all that move)")
    parser.add_argument("--gap", type=float, default=0.0, help="a pause longer than so many seconds begins another demonstration")
    parser.add_argument("--unit", default="", help="unit of the positions, where the source does not say: m, mm, rad, deg")
    return parser.parse_args(words)


def report(recordings, left_out, path):
    """What was written, a line each."""
    first = recordings[0]
    where = f" in the frame {first.frame}" if first.frame else ""
    yield f"{path}: {len(recordings)} demonstration(s), {', '.join(first.coordinates)} [{first.unit or 'unit not known'}]{where}"
    if left_out:
        yield f"  left out: {', '.join(left_out)}"
    for k, r in enumerate(recordings):
        about = " ".join(str(r.origin[key]) for key in ("topic", "column", "type", "episode") if key in r.origin)
        steps = np.diff(r.time)
        notes = r.origin.get("notes", "")
        yield (
            f"  {k}: {os.path.basename(os.path.normpath(r.source))} {about}: {len(r.time)} samples, "
            f"{r.time[-1] - r.time[0]:.3g} s, longest step {steps.max():.2g} s{'; ' + notes if notes else ''}"
        )


def main(words=None):
    try:
        options = arguments_of(words)
        found = [r for source in options.sources for r in read(source, options)]
        recordings = [part for r in found for part in split_at_gaps(r, options.gap)]
        for r in recordings:
            r.unit = options.unit or r.unit
        check(recordings)
        left_out = with_coordinates(recordings, options.coordinates)
        write(options.out, recordings)
    except ImportRefused as error:
        print(f"s2nnds: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"s2nnds: import: {error}", file=sys.stderr)
        return 2
    for line in report(recordings, left_out, options.out):
        print(line)
    return 0


if __name__ == "__main__":
    sys.exit(main())
