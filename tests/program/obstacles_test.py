#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Obstacles from files: a run keeps them, is verified where they are not, and says where they have changed."""

import os

import command_line
import h5py
from command_line import SINE, ProgramTest

PLACE = '{type="point_cloud", file="maps/scan.csv", radius=0.05, inflate=0.02}'


class ObstacleFilesTest(ProgramTest):
    def write(self, name, text):
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def test_a_run_keeps_what_its_obstacle_was_made_from(self):
        scan = "x,y\n-0.4,0.35\n-0.35,0.4\n"
        self.write("data/maps/scan.csv", scan)
        words = ("--data", "data")
        changes = command_line.settings({"problem.unsafe": PLACE})
        _, _, err = self.call("train", SINE, *changes, *words, "--out", "a.h5")
        self.assertNotIn("error", err)
        with h5py.File(os.path.join(self.folder, "a.h5")) as file:
            stored = file["problem/files/0"]
            self.assertEqual(stored.attrs["name"], "maps/scan.csv")
            self.assertEqual(bytes(stored[:]).decode(), scan)
            self.assertIn("points of maps/scan.csv (2) radius 0.05] inflated by 0.02", file["problem"].attrs["unsafe"])
            self.assertLess(file["grid/unsafe"][()].min(), 0.0)
        # Unchanged: nothing is said.
        code, out, err = self.call("evaluate", "a.h5", *words)
        self.assertNotIn("scan.csv", err, out)
        # Changed: said, and the run's own copy is used.
        self.write("data/maps/scan.csv", "x,y\n0.5,0.5\n")
        _, _, err = self.call("verify", "a.h5", "--method", "sampled", *words)
        self.assertIn("maps/scan.csv in data is not what this run was made with", err)
        # Gone: the run has it.
        os.remove(os.path.join(self.folder, "data/maps/scan.csv"))
        code, out, err = self.call("verify", "a.h5", "--method", "sampled", *words)
        self.assertIn(code, (0, 3), err)
        # A new run needs it.
        self.assert_refused(
            self.call("train", SINE, *changes, *words, "--out", "b.h5"), "problem.unsafe", "cannot read data/maps/scan.csv"
        )

    def test_bad_obstacles_are_refused(self):
        self.write("data/hole.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n")
        self.write("data/scan.csv", "0.1,0.2\n0.3,nan\n")
        for unsafe, *expected in (
            ('{type="mesh", file="hole.obj"}', "mesh", "2 dimensions, expected 3"),
            ('{type="point_cloud", file="scan.csv", radius=0.1}', "scan.csv:2", "'nan'"),
            ('{type="polygon", vertices=[[0, 0], [1, 1], [1, 0], [0, 1]]}', "neither cross nor touch"),
            ('{type="occupancy_image", file="none.yaml"}', "cannot read data/none.yaml"),
            ('{type="polygon", vertices=[[-1, -1], [1, -1], [0, 1]]}', "covers the goal"),
        ):
            result = self.call("train", SINE, "--set", f"problem.unsafe={unsafe}", "--data", "data", "--out", "a.h5")
            self.assert_refused(result, "problem.unsafe", *expected)
            self.assertFalse(os.path.exists(self.path("a.h5")))


if __name__ == "__main__":
    command_line.main()
