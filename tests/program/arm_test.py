#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The links of an arm as an obstacle in joint space: preview in two and seven joints, what a run keeps, the proof and
that s2nnds-check (S2NNDS_CHECK is its path) refuses it, bad input."""

import json
import os
import subprocess
import unittest

import command_line
import h5py
import numpy as np
from command_line import PROJECT, ProgramTest, write_network

RECORDINGS = os.path.join(PROJECT, "experiments/poses/arms")
PLANAR = os.path.join(PROJECT, "experiments/configs/poses/planar_arm.toml")
SEVEN = os.path.join(PROJECT, "experiments/configs/poses/seven_joints.toml")
# Behind the goal, so that networks written by hand are right.
BEHIND = '[{ type = "ball", center = [-0.75, 0.1, 0.0], radius = 0.05, inflate = 0.01 }]'
SMALL = command_line.settings({"problem.unsafe.obstacles": BEHIND, "training.rounds": 2, "verification.method": '"sampled"'})


def touches(q):
    """Whether a link of the planar arm touches the ball of BEHIND, at joint angles [N, 2]; by many points of its links."""
    elbow = 0.5 * np.stack([np.cos(q[:, 0]), np.sin(q[:, 0])], axis=1)
    turned = q.sum(axis=1)
    hand = elbow + 0.4 * np.stack([np.cos(turned), np.sin(turned)], axis=1)
    shares = np.linspace(0, 1, 200)[:, None, None]
    points = np.concatenate([shares * elbow, (1 - shares) * elbow + shares * hand])
    return np.linalg.norm(points - [-0.75, 0.1], axis=2).min(axis=0) < 0.06 + 0.05


class ArmTest(ProgramTest):
    def changed(self, config, *changes):
        """A copy of a configuration with texts in it replaced."""
        with open(config, encoding="utf-8") as file:
            text = file.read()
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new)
        with open(self.path("arm.toml"), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path("arm.toml")

    def test_preview_tells_what_it_sees(self):
        for config, joints in ((PLANAR, 2), (SEVEN, 7)):
            code, out, err = self.call("preview", config, "--data", RECORDINGS, "--out", self.path("preview.png"))
            self.assertEqual(code, 0, out + err)
            self.assertNotIn("passes through the obstacle", out)
            self.assertIn(f"{joints}", out)

    def test_a_run_is_proved_and_checked(self):
        run = self.path("run.h5")
        code, _, err = self.call("train", PLANAR, "--data", RECORDINGS, *SMALL, "--threads", 1, "--out", run)
        self.assertIn(code, (0, 3), err)
        k, eye, none = 30.0, np.eye(2), np.zeros(2)
        sides, limits = np.vstack([eye, -eye]), np.array([0.1, 0.3, 1.2, 0.3])
        with h5py.File(run, "r+") as file:
            goal, scale = file["data/goal"][()], file["data"].attrs["position_scale"]
            write_network(file, "f", [(-eye, none, "identity")], "zero_at_origin")
            write_network(file, "V", [(eye, none, "identity")], "squared_norm", 0.05)
            write_network(file, "B", [(k * sides, -k * limits, "tanh"), (np.ones((1, 4)), [3.2], "identity")])
            file["certificate"].attrs["weight_hash"] = ""
            del file["certificate/conditions"]
            file.create_group("certificate/conditions", track_order=True)
        code, out, err = self.call("verify", run, "--method", "proof", "--json")
        self.assertEqual(code, 0, out + err)
        found = json.loads(out.splitlines()[-1])
        self.assertEqual(found["guarantee"], "invariant")
        self.assertIn("arm of 2 joints (modified DH)", found["statement"])
        # No safe start touches, and some of those of the workspace do.
        q = np.random.default_rng(3).uniform([-1.2, -1.6], [2.4, 2.6], (20000, 2))
        z = (q - goal) / scale
        safe = np.tanh(k * (z @ sides.T - limits)).sum(axis=1) + 3.2 <= 0
        self.assertGreater(touches(q).sum(), 30)
        self.assertGreater(safe.sum(), 1000)
        self.assertFalse((touches(q) & safe).any())
        # The run is all that is needed.
        with h5py.File(run) as file:
            scope = file["certificate"].attrs["scope"]
        self.assertIn('joint_unit = "rad"', scope)
        self.assertEqual(self.call("evaluate", run)[0], 0)
        if "S2NNDS_CHECK" in os.environ:
            done = subprocess.run([os.environ["S2NNDS_CHECK"], run], capture_output=True, text=True, timeout=300, check=False)
            # It does not vouch for what it does not understand.
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn(", which this program cannot check", done.stderr)

    def test_bad_input_is_refused(self):
        rows = "dh = [[0, 0, 0, 0], [0.5, 0, 0, 0]]"
        for change, words in (
            ((rows, "dh = [[0, 0, 0, 0]]"), ("arm: dh has 1 rows", "expected 2, one a joint")),
            ((rows, "dh = [[0, 0, 0], [0.5, 0, 0, 0]]"), ("dh[0]: found 3 numbers, expected 4",)),
            ((rows, "dh = [[0, 0, nan, 0], [0.5, 0, 0, 0]]"), ("dh", "nan")),
            (("radius = 0.05", "spheres = [[4, 0, 0, 0, 0.1]]"), ("spheres[0]: found frame 4, expected one of 0 (the base) to 2",)),
            (("radius = 0.05\n", ""), ("found no bodies",)),
            (("radius = 0.05\n", "radius = 0.05\njoint_unit = \"deg\"\n"), ('joint_unit = "deg"', "expected that of the data, rad")),
            (("[problem]", "[problem]\nframe = \"normalised\""), ("expected joint angles", "normalised")),
            (('state = "joints"\nunit = "rad"', 'unit = "mm"'), ("arm: found coordinates in mm", 'data.state = "joints"')),
            (("center = [0.5, 0.68, 0.0]", "center = [0.5, 0.68]"), ("obstacles[0]: ball: center has 2 numbers, expected 3",)),
            (("center = [0.5, 0.68, 0.0]", "center = [0.0, 0.7, 0.0]"), ("covers the goal",)),
        ):
            with self.subTest(change=change):
                config = self.changed(PLANAR, change)
                self.assert_refused(self.call("train", config, "--data", RECORDINGS, "--out", self.path("no.h5")), *words)
                self.assertFalse(os.path.exists(self.path("no.h5")))


if __name__ == "__main__":
    command_line.main()
