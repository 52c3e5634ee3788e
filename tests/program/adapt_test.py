#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The first certificate, certificates for a scene that has changed, and motions that do not follow what was shown."""

import json
import os
import unittest

import command_line
import numpy as np
from command_line import SINE, ProgramTest


class UntilCertifiedTest(ProgramTest):
    def test_stops_at_the_first_certificate_and_goes_on_from_there(self):
        run, finished = self.path("first.h5"), self.path("finished.h5")
        few = ("--set", "training.imitation_finetune_rounds=1", "--set", "training.enlarge_rounds=1", "--threads", 1)
        code, out, err = self.call("train", SINE, *few, "--out", run, "--until", "certified", "--json")
        self.assertEqual(code, 0, err)
        first = json.loads(out.splitlines()[-1])
        self.assertEqual(first["guarantee"], "invariant")
        self.assertTrue(first["follows"])
        code, out, err = self.call("train", "--resume", run, "--out", finished, "--threads", 1, "--json")
        self.assertEqual(code, 0, err)
        self.assertEqual(json.loads(out.splitlines()[-1])["rounds"], first["rounds"] + 2)
        unbroken = self.path("unbroken.h5")
        self.assertEqual(self.call("train", SINE, *few, "--out", unbroken)[0], 0)
        self.assertEqual(command_line.differences(unbroken, finished), [])


class AdaptTest(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.run_file = os.path.join(cls.store, "old.h5")
        code, _, err = command_line.call("train", SINE, "--out", cls.run_file, "--until", "certified", "--set",
                                         "evaluation.area_cells=20", cwd=cls.store)
        assert code == 0, err

    def adapt(self, *words):
        return self.call("adapt", self.run_file, *words, "--out", self.path("new.h5"), "--json")

    def adapted(self, *words):
        code, out, err = self.adapt(*words)
        self.assertEqual(code, 0, err)
        found = json.loads(out.splitlines()[-1])
        self.assertEqual(found["guarantee"], "invariant")
        return found

    def test_holds_where_the_obstacle_shrinks(self):
        found = self.adapted("--set", "problem.unsafe.radius=0.05")
        self.assertEqual(found["adaptation"]["outcome"], "held")
        self.assertEqual(found["adaptation"]["motion_change"], 0.0)
        self.assertEqual(found["weight_hash"], self.hash_of(self.run_file))
        self.assertIn("radius 0.05", found["problem"]["unsafe"])

    def hash_of(self, run):
        return json.loads(self.call("info", run, "--json")[1].splitlines()[-1])["weight_hash"]

    def test_follows_an_obstacle_that_moved(self):
        found = self.adapted("--set", "problem.unsafe.center=[-0.3, 0.3]")
        self.assertIn(found["adaptation"]["outcome"], ("adapted", "anew"))
        self.assertNotEqual(found["weight_hash"], self.hash_of(self.run_file))
        # It is a run like any other: proved again by itself, and trained on.
        code, _, err = self.call("verify", self.path("new.h5"), "--method", "proof")
        self.assertEqual(code, 0, err)

    def test_refuses_what_it_cannot_change(self):
        for words, expected in ((("--set", "training.rounds=3"), "expected keys below problem."),
                                (("--set", "data.goal=[0.1, 0.0]"), "another goal or other demonstrations"),
                                (("--set", 'data.files=["more.csv"]'), "another goal or other demonstrations"),
                                (("--set", "problem.unsafe.center=[0.0, 0.0]"), "problem.unsafe"),
                                (("--set", "problem.unsafe.centre=[0.1, 0.1]"), "centre")):
            with self.subTest(words=words):
                code, _, err = self.adapt(*words)
                self.assertEqual(code, 2, err)
                self.assertEqual(len(err.strip().splitlines()), 1, err)
                self.assertIn(expected, err)
                self.assertFalse(os.path.exists(self.path("new.h5")))


class FidelityTest(ProgramTest):
    def test_a_certificate_of_another_motion_is_no_success(self):
        """A stroke with a loop: x' = f(x) takes a short cut, is certified, and must say so."""
        folder = self.path("loop")
        os.makedirs(folder)
        s = np.linspace(0.0, 1.0, 200)
        turn = 2 * np.pi * np.clip((s - 0.3) / 0.4, 0.0, 1.0)
        x = 1.0 - s - 0.25 * np.sin(turn)
        y = 0.25 * (1.0 - np.cos(turn))
        for k in range(3):
            rows = np.stack([4 * s, x, y + 0.005 * k * (1 - s)], axis=1)
            np.savetxt(os.path.join(folder, f"{k}.csv"), rows, delimiter=",", header="time,x,y", comments="")
        config = self.path("loop.toml")
        with open(config, "w") as file:
            file.write('name = "loop"\n[data]\nsource = "csv"\nfiles = ["loop/*.csv"]\ntest = []\n'
                       '[training]\nimitation_finetune_rounds = 0\nenlarge_rounds = 0\nrounds = 12\n'
                       '[problem]\nunsafe = { type = "ball", center = [0.2, -0.2], radius = 0.05 }\n')
        code, out, err = self.call("train", config, "--data", self.folder, "--out", self.path("loop.h5"), "--json")
        self.assertEqual(code, 3, err)
        found = json.loads(out.splitlines()[-1])
        self.assertFalse(found["follows"])
        self.assertIn("does NOT follow", found["remarks"][0])
        self.assertIn("comes back to", found["remarks"][0])
        self.assertEqual(self.call("info", self.path("loop.h5"))[0], 0)


if __name__ == "__main__":
    command_line.main()
