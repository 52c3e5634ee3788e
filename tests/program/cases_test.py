#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Recordings that failed for users, small equivalents of them in ../shared/cases: what is found and said of each."""

import json
import os
import unittest

import command_line
import numpy as np
from command_line import PROJECT, ProgramTest, settings
from s2nnds.run import Run

CASES = os.path.join(os.path.dirname(PROJECT), "shared/cases")
# The obstacles of these configurations are normalised; where the case is about something else, this stands for it.
NO_OBSTACLE = {"problem.unsafe": '{ type = "none" }'}


@unittest.skipUnless(os.path.isdir(CASES), f"{CASES}: not there")
class CasesTest(ProgramTest):
    def case(self, name):
        folder = os.path.join(CASES, name)
        return os.path.join(folder, "config.toml"), folder

    def train(self, name, changes=None, words=()):
        config, folder = self.case(name)
        return self.call("train", config, *settings(changes), "--data", folder, "--threads", 1, "--out", "run.h5", "--json", *words)

    def trained_case(self, name, changes=None):
        """(the run, stderr) of a short training."""
        code, out, err = self.train(name, changes)
        self.assertIn(code, (0, 3), err + out)
        return Run(self.path("run.h5")), err

    def seen(self, name, *words, code=0):
        """What `preview` says, as JSON, and its stderr."""
        config, folder = self.case(name)
        got, out, err = self.call("preview", config, "--data", folder, "--out", "seen.png", "--json", *words)
        self.assertEqual(got, code, out + err)
        return json.loads(out.strip().split("\n")[-1]), err

    def exported_speed(self, run):
        """The exported policy's mean speed along the demonstrations, in the data's unit per second."""
        code, _, err = self.call("export", "run.h5", "--out", "policy.h")
        self.assertEqual(code, 0, err)
        x = np.vstack([d.position for d in run.data.demonstrations])
        return float(np.linalg.norm(run.velocity(x), axis=1).mean())

    def test_01_stamps_in_bursts(self):
        """12 s at 0.16 m/s, two of three stamps 5 us apart: the speeds are the robot's, and no motion is cut."""
        run, err = self.trained_case("01-burst-time-stamps")
        self.assertIn("67 time stamps in bursts merged", err)
        self.assertNotIn("rest", err)
        for d in run.data.demonstrations:
            self.assertAlmostEqual(d.time[-1] - d.time[0], 12.0, delta=0.1)
        self.assertAlmostEqual(np.median(np.linalg.norm(run.data.demonstrations[0].velocity, axis=1)), 0.16, delta=0.01)
        self.assertTrue(0.05 < self.exported_speed(run) < 0.4)

    def test_02_closed_loop(self):
        none, position = ("--set", "problem.unsafe={type='none'}"), ("--set", 'data.state="position"')
        seen, _ = self.seen("02-closed-loop-does-not-move", *none)
        self.assertEqual(seen["problems"], [])  # a phase tells its start from its end
        seen, _ = self.seen("02-closed-loop-does-not-move", *none, *position)
        self.assertIn("ends where it starts", seen["problems"][0])
        # As it is, its obstacle is wrong, too: what no training can do comes first.
        code, _, err = self.train("02-closed-loop-does-not-move")
        self.assertEqual(code, 2, err)
        self.assertIn("3 of 3 end where they start or were before", " ".join(err.splitlines()[:-1]))
        self.assertIn("no points in the workspace", err.splitlines()[-1])
        run, err = self.trained_case("02-closed-loop-does-not-move", NO_OBSTACLE)
        self.assertIn("auto chose phase", err)
        self.assertEqual((run.dimension, run.data.places), (3, 2))
        _, err = self.trained_case("02-closed-loop-does-not-move", {**NO_OBSTACLE, "data.state": '"position"'})
        self.assertIn("demonstration 0 ends where it starts (0 m apart): the start is the goal", err)

    def test_04_loop(self):
        self.assertEqual(self.seen("04-loop-in-the-stroke")[0]["problems"], [])
        seen, _ = self.seen("04-loop-in-the-stroke", "--set", 'data.state="position"')
        self.assertIn("it crosses itself", seen["problems"][0])
        run, err = self.trained_case("04-loop-in-the-stroke")
        self.assertIn("3 of 3 cross themselves", err)
        self.assertEqual(run.data.places, 2)
        _, err = self.trained_case("04-loop-in-the-stroke", {"data.state": '"position"'})
        self.assertIn("demonstration 0 is at (-0.554, 0.007) m twice", err)

    def test_05_two_goals(self):
        seen, err = self.seen("05-two-goals", code=2)
        for text in (seen["refusals"][0], err, self.train("05-two-goals")[2]):
            self.assertIn("demonstration 0 ends 0.1999 m from the goal", text)
            self.assertIn('data.goal = "each"', text)
        self.assertFalse(os.path.exists(self.path("run.h5")))
        # Chosen, the goal is kept, and the obstacle has one place.
        run, err = self.trained_case("05-two-goals", {"data.goal": '"each"'})
        np.testing.assert_allclose(run.data.goal, [0.0, 0.0], atol=1e-3)
        self.assertIn("each is moved to end there", err)

    def test_06_obstacle_in_the_users_unit(self):
        seen, _ = self.seen("06-obstacle-in-user-units")
        self.assertEqual(seen["unit"], "mm")
        np.testing.assert_allclose(seen["clearances"], [29.8, 13.0, 0.0], atol=0.5)
        self.assertIn("demonstration 2 passes through the obstacle", seen["problems"][0])
        run, err = self.trained_case("06-obstacle-in-user-units")
        np.testing.assert_allclose(run.data.goal, [500.0, 200.0])
        self.assertIn("ball centre (300, 400) radius 40", run.problem.unsafe)
        self.assertLess(np.linalg.norm(run.velocity(np.array([[500.0, 200.0]]))), 1e-6)
        with open(self.exported(), encoding="utf-8") as file:
            text = file.read()
        self.assertIn("500", text)
        self.assertIn("mm", text)

    def exported(self):
        code, _, err = self.call("export", "run.h5", "--out", "policy.h")
        self.assertEqual(code, 0, err)
        return self.path("policy.h")

    def assert_three_seconds_in_half_a_metre(self, run):
        for d in run.data.demonstrations:
            self.assertAlmostEqual(d.time[-1] - d.time[0], 3.0, delta=1e-2)
        self.assertTrue(0.1 < self.exported_speed(run) < 0.3)

    def test_07_and_08_stamps_in_nanoseconds_since_1970(self):
        for name, column in (("07-ros-csv", "%time"), ("08-time-in-nanoseconds", "time")):
            run, err = self.trained_case(name, NO_OBSTACLE)
            self.assertIn("taken as ns", err)
            self.assert_three_seconds_in_half_a_metre(run)
            columns = '{ time = "%s"' % column
            if name == "07-ros-csv":
                columns += ', position = ["field.pose.position.x", "field.pose.position.y"]'
            run, err = self.trained_case(name, {**NO_OBSTACLE, "data.columns": columns + " }", "data.time_unit": '"ns"'})
            self.assert_three_seconds_in_half_a_metre(run)
            # As it is, its obstacle lies elsewhere: how the times were read comes first.
            err = self.train(name)[2].splitlines()
            self.assertIn("taken as ns", " ".join(err[:-1]))
            self.assertIn("no points in the workspace", err[-1])
            refused = self.train(name, {**NO_OBSTACLE, "data.time_unit": '"s"'})
            self.assert_refused(refused, "duration of 3e+09 s", "data.time_unit")

    def test_10_three_demonstrations(self):
        run, _ = self.trained_case("10-fewer-than-seven-demonstrations", NO_OBSTACLE)
        self.assertEqual(len(run.data.demonstrations), 3)
        code, out, err = self.call("info", "run.h5")
        self.assertIn("3 train, 0 test", out, err)

    def test_11_repairs(self):
        run, err = self.trained_case("11-repair-recordings", NO_OBSTACLE)
        self.assertIn("1 repeated time stamp merged", err)
        self.assertNotIn("rest", err)
        # What users edited by hand: a row of NaN, a pause, several episodes in one file.
        u = np.linspace(0.0, 1.0, 121)
        s = u**3 * (10 + u * (6 * u - 15))
        rows = ["episode,time,x,y"]
        for k in range(3):
            for i, (t, at) in enumerate(zip(u, s)):
                x = "nan" if (k, i) == (1, 60) else f"{0.1 + 0.4 * at:.6f}"
                rows.append(f"{k},{3 * t:.6f},{x},{0.2 + 0.02 * k * (1 - at):.6f}")
            rows += [f"{k},{3 + 0.025 * j:.6f},0.5,0.2" for j in range(1, 61)]
        with open(self.path("long.csv"), "w", encoding="utf-8") as file:
            file.write("\n".join(rows) + "\n")
        code, out, err = self.call("new", "long.csv", "--out", "long.toml")
        self.assertEqual(code, 0, err)
        self.assertIn("3 demonstration(s)", out)
        self.assertIn("1: 1 sample with missing, NaN or infinite numbers dropped", out)
        self.assertIn("of rest at the end cut", out)
        self.assertIn("ends        within 0 m", out)

    def test_12_six_joints(self):
        changes = {"problem.unsafe": '{ type = "ball", center = [20, -15, -15, 35, 30, -25], radius = 2.0 }', **{}}
        word = "a proof in 6 dimensions"
        config, folder = self.case("12-six-joints")
        unsafe = f"problem.unsafe={changes['problem.unsafe']}"
        for method in ((), ("--set", 'verification.method="conformal"')):
            seen, _ = self.seen("12-six-joints", "--set", unsafe, *method)
            self.assertNotIn(word, " ".join(seen["problems"]))
        seen, _ = self.seen("12-six-joints", "--set", unsafe, "--set", 'verification.method="proof"')
        self.assertIn(word, " ".join(seen["problems"]))
        out = self.call("new", *(os.path.join(folder, f"d{k}.csv") for k in range(3)), "--out", "six.toml")[1]
        self.assertNotIn(word, out)
        with open(self.path("six.toml"), encoding="utf-8") as file:
            self.assertIn('method = "conformal"', file.read())


if __name__ == "__main__":
    command_line.main()
