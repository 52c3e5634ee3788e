#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Fetches public recordings of poses, time, position and unit quaternion a sample, and writes them as the readers take them.

    python3 fetch_recordings.py SOURCE DIR              # DIR/SOURCE/*.h5; train with --data DIR
    python3 fetch_recordings.py SOURCE DIR --from PATH  # PATH: the source's file, or a folder with its files, fetched by hand

SOURCE is robotasks9 (nine tasks taught to a Franka arm, nine demonstrations each) or myodm (objects led to the mouth).
What is there already stays and is not fetched again. Bytes with another SHA-256 than expected are never written.
Exit code 2 and one line: what was found, what was expected.
"""

import argparse
import hashlib
import http.client
import io
import os
import pathlib
import subprocess
import sys
import tempfile
import urllib.request
import zipfile
from dataclasses import dataclass

import h5py
import numpy as np

SECONDS = 60  # without an answer, after which a download ends


class Refused(Exception):
    """One line: what was found and what was expected."""


@dataclass
class Demonstration:
    time: np.ndarray  # [M] s
    position: np.ndarray  # [M, 3], in the source's unit
    quaternion: np.ndarray  # [M, 4], w x y z


@dataclass
class Source:
    notice: str  # whose they are, the licence, what to cite
    unit: str
    files: dict  # what is fetched: name -> SHA-256
    motions: dict  # what is written: name -> the file of `files` that holds it
    fetch: object  # (source, file's name, folder) -> its bytes; the folder is for what passes by
    demonstrations: object  # (motion's name, file's bytes) -> the Demonstrations


# --- RoboTasks9: a file a task, an array [9 demonstrations, 1000 samples, px py pz qw qx qy qz]. It has no times: the
# authors' own reader counts 60 samples a second. It names no unit: centimetres are what a Franka arm's reach leaves.

ROBOTASKS9_AT = (
    "https://raw.githubusercontent.com/sayantanauddy/clfd-snode/"
    "cf610acbaa8264d9d39df44439d8d7377e689009/datasets/robottasks/pos_ori/"
)
ROBOTASKS9_RATE = 60.0


def robotasks9_bytes(source, name, folder):
    with urllib.request.urlopen(ROBOTASKS9_AT + name, timeout=SECONDS) as answer:
        return answer.read()


def robotasks9_demonstrations(motion, content):
    table = np.load(io.BytesIO(content), allow_pickle=False)
    if table.ndim != 3 or table.shape[2] != 7 or not np.isfinite(table).all():
        raise Refused(f"{motion}: found an array {list(table.shape)}; expected finite numbers [demonstrations, samples, 7]")
    time = np.arange(table.shape[1]) / ROBOTASKS9_RATE
    return [Demonstration(time, part[:, :3], part[:, 3:]) for part in table]


ROBOTASKS9_FILES = {
    "bottle2shelf.npy": "4866e529c32a3ed764096e33105a03aa66525e232d03e7c436559f499f3ae596",
    "matfolding.npy": "b329e821ad21ae8df581417ca9784f32f81c617d1c9cbdf73148f425d24c1f59",
    "obstaclerotate.npy": "85096f3937ad73500e44178bd37145dbb45f50bc503381ee6d261b66583e503b",
    "openbox.npy": "22c56b8ec0c0c7ae27f1ebbd388567ff006156c67476c238860fa3704ab8834f",
    "pan2stove.npy": "21aa011a347e080f46f818d828c0595e8f3d45508d93744506e2e9f3bee1bb1e",
    "platestandingtolying.npy": "0a227873bc56c923fb8ec7bf73830eefbf0fdac2b27bf829fb0df72f266faf49",
    "pouring.npy": "99ed10bb456f3ecca4ae1efe5503a3c46eb23f1526ef66f1c9fcc411be558fa8",
    "scoop.npy": "670071accdb9c4c80d35762ee20f1180cc8095845ee6d7c9745d20c876c46f55",
    "wineglass.npy": "ad56e3607934bded85dc57c241bd50aba80fc66809cb6e5e54a09950a397ab92",
}

# --- MyoDM: the Python package robohive has a NumPy archive a motion: time [M], object [M, px py pz qw qx qy qz] in m.

MYODM_WHEEL = "robohive-0.7.0-py2.py3-none-any.whl"
MYODM_MEMBER = "robohive/envs/myo/myodm/data/MyoHand_{}.npz"


def myodm_bytes(source, name, folder):
    """The wheel as pip gets it; nothing of it is installed or run."""
    version = "==".join(name.split("-")[:2])
    requirements = pathlib.Path(folder, "requirements.txt")
    requirements.write_text(f"{version} --hash=sha256:{source.files[name]}\n", encoding="utf-8")
    words = "download --quiet --disable-pip-version-check --retries 1 --no-deps --require-hashes --only-binary :all:"
    command = [sys.executable, "-m", "pip", *words.split(), "--dest", folder, "--requirement", str(requirements)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if line and not line.startswith("WARNING")]
        raise OSError(f"pip could not get {version}: {said[-1] if said else 'no reason told'}")
    return pathlib.Path(folder, name).read_bytes()


def myodm_demonstrations(motion, content):
    """The way there: the recording goes on to put the object back, and a motion cannot end where it starts."""
    with zipfile.ZipFile(io.BytesIO(content)) as wheel:
        stored = np.load(io.BytesIO(wheel.read(MYODM_MEMBER.format(motion))), allow_pickle=False)
    time, pose = stored["time"], stored["object"]
    if pose.shape != (len(time), 7) or not (np.isfinite(time).all() and np.isfinite(pose).all()):
        raise Refused(f"{motion}: found an array {list(pose.shape)} for {len(time)} times; expected finite numbers, 7 a sample")
    farthest = int(np.argmax(np.linalg.norm(pose[:, :3] - pose[0, :3], axis=1)))
    way = slice(0, farthest + 1)
    return [Demonstration(time[way], pose[way, :3], pose[way, 3:])]


SOURCES = {
    "robotasks9": Source(
        notice="RoboTasks9, (c) 2023 Sayantan Auddy, MIT licence: github.com/sayantanauddy/clfd-snode. Cite: S. Auddy,\n"
        "J. Hollenstein, M. Saveriano, A. Rodriguez-Sanchez and J. Piater, \"Scalable and Efficient Continual Learning from\n"
        "Demonstration via a Hypernetwork-generated Stable Dynamics Model\", IEEE Transactions on Cognitive and\n"
        "Developmental Systems, 2026.",
        unit="cm",
        files=ROBOTASKS9_FILES,
        motions={name.removesuffix(".npy"): name for name in ROBOTASKS9_FILES},
        fetch=robotasks9_bytes,
        demonstrations=robotasks9_demonstrations,
    ),
    "myodm": Source(
        notice="MyoDM, part of RoboHive 0.7.0, Apache licence 2.0: sites.google.com/view/robohive. The motions go back to the\n"
        "recordings of GRAB, which its authors give for research (grab.is.tue.mpg.de): ask them before another use.\n"
        "Cite: O. Taheri, N. Ghorbani, M. J. Black and D. Tzionas, \"GRAB: A Dataset of Whole-Body Human Grasping of\n"
        "Objects\", ECCV, 2020; S. Dasari, A. Gupta and V. Kumar, \"Learning Dexterous Manipulation from Exemplar Object\n"
        "Trajectories and Pre-Grasps\", ICRA, 2023.",
        unit="m",
        files={MYODM_WHEEL: "7bf4edb1fa923288cb207a786331e267b19cf2f84470061a46a0c7ac890f6a23"},
        motions=dict.fromkeys(("bowl_drink2", "cup_drink1", "mug_drink3", "wineglass_drink1"), MYODM_WHEEL),
        fetch=myodm_bytes,
        demonstrations=myodm_demonstrations,
    ),
}


def checked(content, name, expected):
    found = hashlib.sha256(content).hexdigest()
    if found != expected:
        raise Refused(f"{name}: found SHA-256 {found} of {len(content)} bytes; expected {expected}")
    return content


def content_of(source, name, by_hand):
    """The file's bytes, from the network or as fetched by hand. Raises Refused."""
    if by_hand is not None:
        path = by_hand / name if by_hand.is_dir() else by_hand
        if path.name != name or not path.is_file():
            raise Refused(f"{by_hand}: found no {name}; expected that file, or a folder that has it")
        return checked(path.read_bytes(), str(path), source.files[name])
    try:
        with tempfile.TemporaryDirectory(prefix="fetch_recordings-") as folder:
            content = source.fetch(source, name, folder)
    except (OSError, http.client.HTTPException) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise Refused(f"cannot fetch {name}: {reason}; expected a network, or --from with the file fetched by hand") from None
    return checked(content, name, source.files[name])


def is_there(path, expected):
    """Whether the motion was written before. Raises Refused where something else has its place."""
    if not os.path.lexists(path):
        return False
    try:
        with h5py.File(path, "r") as file:
            found = str(file["demonstrations"].attrs.get("sha256", "none"))
    except (OSError, KeyError):
        found = "none"
    if found != expected:
        raise Refused(
            f"{path}: found a file made of SHA-256 {found}; expected none there, or one made of {expected} (move it away)"
        )
    return True


def one_sign(quaternion):
    """q and -q are one orientation: neighbours get the sign under which they lie closest."""
    turns = np.sign(np.sum(quaternion[1:] * quaternion[:-1], axis=1))
    return quaternion * np.cumprod(np.concatenate([[1.0], np.where(turns < 0, -1.0, 1.0)]))[:, None]


def write(path, demonstrations, unit, source, digest):
    """As `s2nnds import` writes; beside its place first, so that no half-written file is left there."""
    part = path.with_name(path.name + ".part")
    with h5py.File(part, "w", track_order=True) as file:
        group = file.create_group("demonstrations", track_order=True)
        group.attrs.update({"unit": unit, "frame": "", "coordinates": ["x", "y", "z"], "source": source, "sha256": digest})
        for k, d in enumerate(demonstrations):
            item = group.create_group(str(k))
            item["time"] = d.time
            item["position"] = d.position
            item["orientation"] = one_sign(d.quaternion)[:, [1, 2, 3, 0]]  # x y z w
    os.replace(part, path)


def fetch(name, folder, by_hand):
    """Writes the motions that are not there. Yields a line each."""
    source = SOURCES[name]
    target = pathlib.Path(folder, name)
    missing = [motion for motion, file in source.motions.items() if not is_there(target / f"{motion}.h5", source.files[file])]
    target.mkdir(parents=True, exist_ok=True)
    contents = {}
    for motion in missing:
        file = source.motions[motion]
        if file not in contents:
            contents = {file: content_of(source, file, by_hand)}
        demonstrations = source.demonstrations(motion, contents[file])
        write(target / f"{motion}.h5", demonstrations, source.unit, f"{name}: {file}", source.files[file])
        yield f"{target / motion}.h5: {len(demonstrations)} demonstration(s), {demonstrations[0].time[-1]:.3g} s [{source.unit}]"
    if not missing:
        yield f"{target} has its {len(source.motions)} files already"


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise Refused(message)


def main(words=None):
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", choices=sorted(SOURCES))
    parser.add_argument("folder", metavar="DIR")
    parser.add_argument("--from", dest="by_hand", metavar="PATH", type=pathlib.Path)
    try:
        options = parser.parse_args(words)
        print(SOURCES[options.source].notice, flush=True)
        for line in fetch(options.source, options.folder, options.by_hand):
            print(line, flush=True)
    except (Refused, OSError) as error:
        print(f"fetch_recordings.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
