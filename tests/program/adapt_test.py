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
        found = self.adapted("--set", "problem.unsafe.center=[-0.5, 0.35]")
        self.assertIn(found["adaptation"]["outcome"], ("adapted", "anew"))
        self.assertNotEqual(found["weight_hash"], self.hash_of(self.run_file))
        # It is a run like any other: proved again by itself, and trained on.
        code, _, err = self.call("verify", self.path("new.h5"), "--method", "proof")
        self.assertEqual(code, 0, err)

    def test_refuses_what_it_cannot_change(self):
        for words, expected in ((("--set", "training.rounds=3"), "expected keys below problem."),
                                (("--set", "data.unit=m"), "expected keys below problem., data.goal"),
                                (("--set", "data.goal=[0.1, 0.0, 0.0]"), "expected 2 finite coordinates"),
                                (("--set", "data.goal=each"), "found something else than a point"),
                                (("--set", 'data.use=[0, 9]'), "data.use"),
                                (("--set", "problem.unsafe.center=[0.0, 0.0]"), "problem.unsafe"),
                                (("--set", "problem.unsafe.centre=[0.1, 0.1]"), "centre")):
            with self.subTest(words=words):
                code, _, err = self.adapt(*words)
                self.assertEqual(code, 2, err)
                self.assertEqual(len(err.strip().splitlines()), 1, err)
                self.assertIn(expected, err)
                self.assertFalse(os.path.exists(self.path("new.h5")))


class AnotherMotionTest(ProgramTest):
    """Strokes in metres past a ball, which stays where it is: another goal, and further demonstrations."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder_of_data = os.path.join(cls.store, "strokes")
        os.makedirs(cls.folder_of_data)
        for k, height in enumerate((0.30, 0.33, 0.36, 0.27)):  # the last one is added later
            s = np.linspace(0.0, 1.0, 120)
            x, y = 0.9 - 0.5 * s, 0.2 + height * np.sin(np.pi * s) ** 2 * (1 - s)
            name = f"{'more' if k == 3 else 'd'}{k}.csv"
            np.savetxt(os.path.join(cls.folder_of_data, name), np.stack([3 * s, x, y], axis=1), delimiter=",",
                       header="time,x,y", comments="")
        config, cls.run_file = os.path.join(cls.store, "strokes.toml"), os.path.join(cls.store, "strokes.h5")
        with open(config, "w", encoding="utf-8") as file:
            file.write('name = "strokes"\n[data]\nsource = "csv"\nunit = "m"\nfiles = ["d*.csv"]\ntest = []\n'
                       '[problem]\nunsafe = { type = "ball", center = [0.62, 0.15], radius = 0.06 }\n')
        code, _, err = command_line.call("train", config, "--data", cls.folder_of_data, "--out", cls.run_file, "--until",
                                         "certified", cwd=cls.store)
        assert code == 0, err

    def adapted(self, *words):
        out_file = self.path("new.h5")
        code, out, err = self.call("adapt", self.run_file, *words, "--data", self.folder_of_data, "--out", out_file, "--json")
        self.assertEqual(code, 0, err)
        self.assertEqual(self.call("verify", out_file, "--method", "proof")[0], 0)
        return json.loads(out.splitlines()[-1])

    def test_the_motion_moves_to_another_goal_and_the_obstacle_stays(self):
        from s2nnds import Run

        goal = [0.42, 0.17]
        found = self.adapted("--set", f"data.goal={goal}")
        self.assertEqual(found["guarantee"], "invariant")
        old, new = Run(self.run_file), Run(self.path("new.h5"))
        np.testing.assert_allclose(new.data.goal, goal)
        self.assertEqual(new.data.position_scale, old.data.position_scale)
        for run in (old, new):
            self.assertGreater(float(np.min(run.barrier([[0.62, 0.15]]))), 0.0)
        self.assertLessEqual(float(np.max(np.abs(new.velocity([goal])))), 1e-12)

    def test_follows_a_further_demonstration_too(self):
        from s2nnds import Run

        found = self.adapted("--set", 'data.files=["d*.csv", "more3.csv"]')
        self.assertEqual(found["guarantee"], "invariant")
        self.assertTrue(found["follows"])
        self.assertEqual(len(Run(self.path("new.h5")).data.demonstrations), 4)


class FidelityTest(ProgramTest):
    def test_a_certificate_of_a_motion_that_does_not_follow_is_no_success(self):
        """Far less is allowed than the network can do: all is proved, and the run must say that it does not follow."""
        code, out, err = self.call("train", SINE, "--set", "evaluation.fidelity=0.002", "--set", "training.imitation_finetune_rounds=0",
                                   "--set", "training.enlarge_rounds=0", "--out", self.path("strict.h5"), "--json")
        self.assertEqual(code, 3, err)
        found = json.loads(out.splitlines()[-1])
        self.assertEqual(found["guarantee"], "invariant")
        self.assertFalse(found["follows"])
        self.assertIn("does NOT follow", found["remarks"][0])

    def test_a_motion_that_follows_nothing_is_no_success(self):
        """A stroke with a loop, wide beside what is allowed: no x' = f(x) follows it, and the run must say so."""
        folder = self.path("loop")
        os.makedirs(folder)
        s = np.linspace(0.0, 1.0, 200)
        turn = 2 * np.pi * np.clip((s - 0.3) / 0.4, 0.0, 1.0)
        x = 1.0 - s - 0.35 * np.sin(turn)
        y = 0.35 * (1.0 - np.cos(turn))
        for k in range(3):
            rows = np.stack([4 * s, x, y + 0.005 * k * (1 - s)], axis=1)
            np.savetxt(os.path.join(folder, f"{k}.csv"), rows, delimiter=",", header="time,x,y", comments="")
        config = self.path("loop.toml")
        with open(config, "w") as file:
            file.write('name = "loop"\n[data]\nsource = "csv"\nfiles = ["loop/*.csv"]\ntest = []\nstate = "position"\n'
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
