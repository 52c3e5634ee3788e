#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The walk-throughs of experiments/walkthroughs, from raw recordings to a header, with a short training."""

import json
import os
import shutil
import subprocess
import sys

import command_line
import h5py
from command_line import PROJECT, ProgramTest

FOLDER = os.path.join(PROJECT, "experiments/walkthroughs")
# More dimensions and a map take longer to look at.
SHORT = {**command_line.SMALL, "evaluation.area_cells": 8, "evaluation.grid_points": 11}


class WalkthroughsTest(ProgramTest):
    def record(self, kind):
        script = os.path.join(FOLDER, "make_recordings.py")
        done = subprocess.run([sys.executable, script, kind, self.path("in")], capture_output=True, text=True)
        if done.returncode == 77:
            self.skipTest(done.stderr.strip())
        self.assertEqual(done.returncode, 0, done.stderr)

    def succeed(self, *words, codes=(0,)):
        code, out, err = self.call(*words)
        self.assertIn(code, codes, f"{words}: {err}{out}")
        return out

    def walk(self, kind, recordings, dimension, unit):
        """From what was recorded or imported on; returns the clearances."""
        out = self.succeed("new", recordings, "--out", "new.toml", "--json")
        found = json.loads(out.strip().split("\n")[-1])
        self.assertEqual((found["dimension"], found["unit"], found["refusals"], found["problems"]), (dimension, unit, [], []))
        config = shutil.copy(os.path.join(FOLDER, f"{kind}.toml"), self.path(f"{kind}.toml"))
        out = self.succeed("preview", config, "--data", "in", "--json")
        seen = json.loads(out.strip().split("\n")[-1])
        self.assertEqual((seen["refusals"], seen["problems"]), ([], []))
        self.assertGreater(min(seen["clearances"]), 0.0)
        self.assertTrue(os.path.exists(seen["figure"]))
        settings = [word for key, value in SHORT.items() for word in ("--set", f"{key}={value}")]
        self.succeed("train", config, "--data", "in", *settings, "--out", "run.h5", codes=(0, 3))
        self.succeed("export", "run.h5", "--out", "policy.h")
        with h5py.File(self.path("run.h5")) as file:
            self.assertEqual(file["data"].attrs["unit"], unit)
            goal = file["data/goal"][()]
        with open(self.path("policy.h"), encoding="utf-8") as file:
            self.assertIn("velocity(", file.read())
        return goal

    def test_arm(self):
        self.record("arm")
        goal = self.walk("arm", "in", 3, "m")
        for found, meant in zip(goal, (0.55, 0.25, 0.12)):
            self.assertAlmostEqual(found, meant, delta=2e-3)

    def test_mobile_robot(self):
        self.record("mobile")
        bags = [f"in/drive_{k}.bag" for k in range(5)]
        out = self.succeed("import", *bags, "--out", "in/drives.h5")
        self.assertIn("in the frame map", out)
        goal = self.walk("mobile", "in/drives.h5", 2, "m")
        self.assertAlmostEqual(goal[0], 4.8, delta=5e-3)

    def test_lerobot(self):
        self.record("lerobot")
        self.succeed("import", "in", "--out", "in/episodes.h5")
        goal = self.walk("lerobot", "in/episodes.h5", 2, "m")
        self.assertAlmostEqual(goal[1], 0.16, delta=1e-3)


if __name__ == "__main__":
    command_line.main()
