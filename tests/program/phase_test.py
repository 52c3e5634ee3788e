#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Motions that cross themselves or end where they start: a phase is chosen, said, drawn, stored and exported. With
S2NNDS_SLOW in the environment, a circle round an obstacle from recordings to a certificate."""

import json
import os
import subprocess
import unittest

import command_line
import numpy as np
from command_line import PROJECT, ProgramTest, settings
from s2nnds.run import Run

UNSAFE = {"problem.unsafe": '{ type = "ball", center = [0.0, 0.0], radius = 0.06 }'}

DRIVER = """
#include "policy.h"
#include <cstdio>
namespace policy = policy_policy;
int main() {
  policy::PhasedMotion motion;
  double x[2] = {0.2, 0.01}, v[2];
  for (int i = 0; i < 3; ++i) {
    std::printf("%.17g %d ", motion.s, motion.safe(x) ? 1 : 0);
    motion.step(x, 0.25, v);
    std::printf("%.17g %.17g\\n", v[0], v[1]);
  }
}
"""


def circle(share, radius=0.2):
    return [0.2 - radius + radius * np.cos(2 * np.pi * share), radius * np.sin(2 * np.pi * share)]


class PhaseTest(ProgramTest):
    def setUp(self):
        super().setUp()
        for k in range(3):
            self.record(f"d{k}", lambda s, k=k: circle(s, 0.2 + 0.004 * k))
        with open(self.path("my.toml"), "w", encoding="utf-8") as file:
            file.write(f'name = "circle"\n[data]\nsource = "csv"\nfiles = ["{self.path("d*.csv")}"]\n')
            file.write('unit = "m"\ntest = [2]\n')
            file.write(f"[problem]\nunsafe = {UNSAFE['problem.unsafe']}\n")

    def record(self, name, positions, seconds=4.0):
        """A recording that moves smoothly from rest to rest through `positions` (a function of 0..1)."""
        time = np.linspace(0, seconds, 161)
        s = time / seconds
        s = s**3 * (10 - 15 * s + 6 * s**2)
        table = np.column_stack([time, np.array([positions(x) for x in s])])
        np.savetxt(self.path(f"{name}.csv"), table, fmt="%.9g", delimiter=",", header="t,px,py", comments="")

    def train(self, changes=None, words=()):
        return self.call("train", "my.toml", *settings(changes), "--threads", 1, "--out", "run.h5", "--json", *words)

    def test_is_chosen_and_said(self):
        code, out, err = self.call("preview", "my.toml", "--json")
        self.assertEqual(code, 0, err)
        self.assertEqual(json.loads(out.strip().split("\n")[-1])["problems"], [])
        self.assertIn("auto chose phase, since of the demonstrations 3 of 3 end where they start or were before", out)
        self.assertIn("whatever the last coordinate", out)
        code, out, err = self.call("new", "d0.csv", "d1.csv", "--out", "new.toml")
        self.assertEqual(code, 0, err)
        with open(self.path("new.toml"), encoding="utf-8") as file:
            self.assertIn('state = "phase"', file.read())
        code, out, err = self.call("preview", "new.toml")
        self.assertEqual(code, 0, err)
        # As asked for otherwise, it is said what no law can follow.
        code, out, err = self.call("preview", "my.toml", "--set", 'data.state="position"')
        self.assertIn("ends where it starts", out)
        self.assertIn('choose data.state = "phase"', out)
        refused = self.call("train", "my.toml", "--set", "execution.period=0.001", "--out", "no.h5")
        self.assertEqual(refused[0], 2)
        self.assertIn("whose states have a phase", refused[2].splitlines()[-1])

    def test_from_training_to_exports(self):
        code, out, err = self.train()
        self.assertIn(code, (0, 3), err)
        self.assertIn("auto chose phase", err)
        run = Run(self.path("run.h5"))
        self.assertEqual((run.dimension, run.data.places), (3, 2))
        self.assertAlmostEqual(run.phase_start, 0.4 * np.pi, delta=0.03)  # the mean length
        self.assertIn("auto chose phase", " ".join(run.data.report))
        for d in run.data.demonstrations:
            self.assertEqual(d.position.shape[1], 3)
            self.assertAlmostEqual(d.position[0, 2], run.phase_start)
            self.assertAlmostEqual(d.position[-1, 2], 0.0)
        for words in (("evaluate", "run.h5"), ("verify", "run.h5", "--method", "sampled"), ("info", "run.h5", "--all")):
            code, _, err = self.call(*words)
            self.assertIn(code, (0, 3), err)
        code, out, err = self.call("plot", "run.h5", "--out", "figures")
        self.assertEqual(code, 0, err)
        for name in ("phase_portrait", "slices", "states", "lyapunov"):
            self.assertTrue(os.path.exists(self.path(f"figures/{name}.png")), name)
        self.header_agrees(run)

    def header_agrees(self, run):
        code, _, err = self.call("export", "run.h5", "--out", "policy.h", "--precision", "double")
        self.assertEqual(code, 0, err)
        with open(self.path("driver.cpp"), "w", encoding="utf-8") as file:
            file.write(DRIVER)
        subprocess.run(["g++", "-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "driver.cpp", "-o", "driver"],
                       cwd=self.folder, check=True, timeout=300)
        rows = subprocess.run(["./driver"], cwd=self.folder, check=True, capture_output=True, text=True).stdout
        s = run.phase_start
        for row in rows.splitlines():
            found = [float(word) for word in row.split()]
            state = np.array([0.2, 0.01, s])
            v = run.velocity(state)
            np.testing.assert_allclose(found[0], s, rtol=1e-12)
            self.assertEqual(found[1] == 1.0, bool(run.safe(state)))
            np.testing.assert_allclose(found[2:], v[:2], rtol=1e-9, atol=1e-12)
            s += 0.25 * v[2]

    def test_a_run_is_the_same_after_it_was_resumed(self):
        whole = self.train(words=("--set", "training.rounds=2"))
        self.assertIn(whole[0], (0, 3), whole[2])
        os.rename(self.path("run.h5"), self.path("whole.h5"))
        again = self.train(words=("--set", "training.rounds=2"))
        self.assertIn(again[0], (0, 3), again[2])
        self.assertEqual(command_line.differences(self.path("whole.h5"), self.path("run.h5")), [])
        code, _, err = self.call("train", "--resume", "run.h5", "--out", "more.h5", "--threads", 1)
        self.assertIn(code, (0, 3), err)

    @unittest.skipUnless(os.environ.get("S2NNDS_SLOW"), "minutes: S2NNDS_SLOW=1 asks for it")
    def test_slow_circle_round_an_obstacle_is_certified(self):
        code, out, err = self.call("train", "my.toml", "--threads", 1, "--out", "run.h5", "--until", "certified", "--json",
                                   timeout=3000)
        self.assertEqual(code, 0, err + out)
        found = json.loads(out.strip().split("\n")[-1])
        self.assertEqual(found["guarantee"], "invariant")
        self.assertTrue(found["follows"])
        self.assertLess(found["dtw_train"], 0.1)
        run = Run(self.path("run.h5"))
        for rollout in run.rollouts:  # all the way round
            x = rollout.position[:, :2] * run.data.position_scale + run.data.goal[:2]
            angle = np.unwrap(np.arctan2(x[:, 1], x[:, 0]))
            self.assertGreater(angle[-1] - angle[0], 0.9 * 2 * np.pi)
        # The obstacle moves: a new certificate for the same loop.
        code, out, err = self.call("adapt", "run.h5", "--set", "problem.unsafe.center=[0.02, 0.02]", "--out", "moved.h5",
                                   timeout=3000)
        self.assertEqual(code, 0, err + out)


if __name__ == "__main__":
    command_line.main()
