# SPDX-License-Identifier: BSD-3-Clause
"""The program s2nnds as the tests of this folder call it. The first argument of each test is its path."""

import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

PROJECT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SINE = os.path.join(PROJECT, "experiments/configs/handwriting/Sine.toml")
sys.path.insert(0, os.path.join(PROJECT, "notebooks_export/python"))

PROGRAM = ""  # main() sets it

# A training that is over in a second, and far from verified.
SMALL = {
    "networks.f.hidden": "[16, 16]",
    "networks.V.hidden": "[16]",
    "networks.B.hidden": "[16]",
    "training.rounds": 3,
    "training.min_rounds": 3,
    "training.steps": 30,
    "training.rollout_points": 200,
    "training.samples": 2000,
    "training.warm_start.steps": 100,
    "training.warm_start.attempts": 1,
    "verification.method": '"sampled"',
    "verification.sampled.samples": 2000,
    "evaluation.area_cells": 20,
    "evaluation.grid_points": 21,
    "evaluation.fidelity": 100.0,  # it follows nothing
}

# What may differ between two runs of one seed: when they ran, and how long they took.
CLOCKS = ("/history/seconds", "/timing", "/certificate/conditions/*/seconds", "/@created")


def torch_export():
    """None, or why the format pt2 cannot be written and read here."""
    try:
        import torch
    except ImportError as error:
        return f"{sys.executable} cannot import torch: {error}"
    if tuple(map(int, torch.__version__.split("+")[0].split(".")[:2])) < (2, 6):
        return f"{sys.executable} has torch {torch.__version__}, expected 2.6 or newer"
    return None


def settings(changes=None):
    values = {**SMALL, **(changes or {})}
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


def environment(changes=None):
    """Passive waiting: with more threads than free cores, spinning ones would stall each other. The program's scripts run
    with the Python that runs the tests."""
    kept = {key: value for key, value in os.environ.items() if key != "S2NNDS_DATA"}
    return {"S2NNDS_PYTHON": sys.executable, **kept, "OMP_WAIT_POLICY": "passive", **(changes or {})}


def start(*words, cwd, variables=None, **options):
    return subprocess.Popen(
        [PROGRAM, *map(str, words)],
        cwd=cwd,
        env=environment(variables),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def call(*words, cwd, timeout=300, **options):
    """(exit code, stdout, stderr) of one call."""
    process = start(*words, cwd=cwd, **options)
    out, err = process.communicate(timeout=timeout)
    return process.returncode, out, err


def _is_clock(name):
    parts = name.split("/")
    for pattern in CLOCKS:
        want = pattern.split("/")
        if all(a in ("*", b) for a, b in zip(want, parts)) and len(want) <= len(parts):
            return True
    return False


def contents(path):
    """Every dataset (name -> array) and attribute (group/@name -> value) of a run file but for its clocks."""
    found = {}

    def note(name, item):
        name = "" if name == "/" else "/" + name
        for key, value in item.attrs.items():
            found[f"{name}/@{key}" if not name.startswith("/certificate/conditions/") else f"{name}/{key}"] = value
        if isinstance(item, h5py.Dataset):
            value = item[()]
            found[name] = b"\0".join(value) if getattr(value, "dtype", None) == object else value  # texts

    with h5py.File(path, "r") as file:
        note("/", file)
        file.visititems(note)
    return {name: value for name, value in found.items() if not _is_clock(name.replace("/timing/@", "/timing/"))}


def differences(path_a, path_b):
    """Names of the items in which two run files differ, bit by bit."""
    a, b = contents(path_a), contents(path_b)
    return sorted(
        name
        for name in a.keys() | b.keys()
        if name not in a or name not in b or np.asarray(a[name]).tobytes() != np.asarray(b[name]).tobytes()
        or np.shape(a[name]) != np.shape(b[name])
    )


def write_network(file, name, layers, head="plain", quadratic=0.0):
    """Replaces a stored network; layers are (weight, bias, activation)."""
    del file[f"networks/{name}"]
    group = file.create_group(f"networks/{name}", track_order=True)
    group.attrs["head"] = head
    group.attrs["quadratic"] = quadratic
    group.attrs["layers"] = len(layers)
    for k, (weight, bias, activation) in enumerate(layers):
        group[f"weight_{k}"] = np.asarray(weight, dtype=float)
        group[f"bias_{k}"] = np.asarray(bias, dtype=float)
        group.attrs[f"activation_{k}"] = activation


# The obstacle beside which certify_by_hand() is right, as settings.
FAR_OBSTACLE = {"problem.unsafe": '{ type = "ball", center = [0.6, 1.1], radius = 0.1 }'}


def certify_by_hand(path):
    """Gives a run with FAR_OBSTACLE networks that meet every condition: f(x) = -x, V(x) = 1.05 |x|^2 and, with
    k = 20, B(x) = sum of softplus(k (+-x_i - c_i)) - 0.3: convex with its least value at the goal, so that it
    falls along f; negative on X0 (x = -1), positive on the obstacle (y >= 1) and on the margin."""
    k, c = 20.0, np.array([1.1, 0.9])
    eye, none = np.eye(2), np.zeros(2)
    with h5py.File(path, "r+") as file:
        write_network(file, "f", [(-eye, none, "identity")], "zero_at_origin")
        write_network(file, "V", [(eye, none, "identity")], "squared_norm", 0.05)
        write_network(
            file,
            "B",
            [
                (np.vstack([k * eye, -k * eye]), -k * np.concatenate([c, c]), "softplus"),
                (np.ones((1, 4)), [-0.3], "identity"),
            ],
        )
        file["certificate"].attrs["weight_hash"] = ""  # what was said of the networks before
        del file["certificate/conditions"]
        file.create_group("certificate/conditions", track_order=True)


class ProgramTest(unittest.TestCase):
    """A folder of its own for each test, and run files that are trained once."""

    _trained = {}

    @classmethod
    def setUpClass(cls):
        cls.store = tempfile.mkdtemp(prefix="s2nnds-store-")
        cls._trained = {}

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.store)

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="s2nnds-test-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def call(self, *words, **options):
        return call(*words, cwd=self.folder, **options)

    def trained(self, name="run.h5", changes=None, config=SINE):
        """A copy of a small trained run."""
        key = repr((config, sorted((changes or {}).items())))
        if key not in self._trained:
            stored = os.path.join(self.store, f"{len(self._trained)}.h5")
            code, _, err = self.call("train", config, *settings(changes), "--threads", 1, "--out", stored)
            self.assertIn(code, (0, 3), err)
            self._trained[key] = stored
        return shutil.copyfile(self._trained[key], self.path(name))

    def certified(self, name="run.h5"):
        """A copy of a run whose networks meet every condition, not verified yet."""
        path = self.trained(name, FAR_OBSTACLE)
        certify_by_hand(path)
        return path

    def assert_refused(self, result, *words, program="s2nnds"):
        """Bad input: exit code 2, nothing on stdout, one line on stderr that says all of `words`. Training says before it how
        recordings were read."""
        code, out, err = result
        err = "".join(line for line in err.splitlines(keepends=True) if not line.startswith("data: "))
        self.assertEqual(code, 2, f"{err}{out}")
        self.assertEqual(out, "")
        self.assertEqual(err.count("\n"), 1, err)
        self.assertTrue(err.startswith(f"{program}: "), err)
        self.assertLess(len(err), 600)
        for word in words:
            self.assertIn(str(word), err)


def driver(name):
    """The driver of that name, which may not have been built."""
    return os.path.join(os.path.dirname(PROGRAM), "../../experiments", name)


def main():
    global PROGRAM
    if len(sys.argv) < 2 or not os.access(sys.argv[1], os.X_OK):
        sys.exit(f"usage: {sys.argv[0]} PATH_OF_S2NNDS [TEST]...")
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main(module="__main__", verbosity=2)
