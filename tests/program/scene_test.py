#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""`s2nnds new` and `s2nnds preview`: what is found, written and drawn; what is wrong is named before any training."""

import json
import os

import command_line
import numpy as np
from command_line import ProgramTest

ROOM = 'problem.unsafe={ type = "box", lower = [0.45, 0.0], upper = [0.55, 0.15] }'


class SceneTest(ProgramTest):
    def record(self, name, positions, seconds=4.0, header="t,px,py", ending="csv"):
        """A recording that moves smoothly from rest to rest through `positions` (a function of 0..1)."""
        time = np.linspace(0, seconds, 120)
        s = time / seconds
        s = s**3 * (10 - 15 * s + 6 * s**2)
        table = np.column_stack([time, np.array([positions(x) for x in s])])
        np.savetxt(self.path(f"{name}.{ending}"), table, fmt="%.9g", delimiter=",", header=header, comments="")

    def reaches(self, count=3, scale=1.0):
        for k in range(count):
            self.record(f"d{k}", lambda s, k=k: scale * np.array([0.2 + 0.6 * s, 0.3 + 0.02 * k * (1 - s) + 0.1 * np.sin(np.pi * s)]))

    def new(self, *words):
        code, out, err = self.call("new", *words, "--out", "my.toml", "--json")
        self.assertEqual(code, 0, err)
        return out, json.loads(out.strip().split("\n")[-1])

    def preview(self, *words, code=0):
        got, out, err = self.call("preview", "my.toml", *words, "--json")
        self.assertEqual(got, code, out + err)
        return out, json.loads(out.strip().split("\n")[-1]), err

    def test_from_recordings_to_a_run(self):
        self.reaches()
        out, found = self.new("d0.csv", "d1.csv", "d2.csv")
        self.assertEqual((found["demonstrations"], found["dimension"], found["unit"]), (3, 2, "m"))
        self.assertEqual((found["refusals"], found["problems"]), ([], []))
        self.assertIn("guessed", out)
        with open(self.path("my.png"), "rb") as file:
            self.assertEqual(file.read(4), b"\x89PNG")
        self.assertEqual(sorted(os.listdir(self.folder)), ["d0.csv", "d1.csv", "d2.csv", "my.png", "my.toml"])
        # It trains as it stands, from anywhere.
        os.mkdir(self.path("elsewhere"))
        code, _, err = command_line.call(
            "train", self.path("my.toml"), *command_line.settings(), "--out", "a.h5", cwd=self.path("elsewhere")
        )
        self.assertIn(code, (0, 3), err)
        # With an obstacle, its clearance is told: the least distance of the lowest path to the box.
        _, seen, _ = self.preview("--set", ROOM)
        s = np.linspace(0.0, 1.0, 10001)
        x, y = 0.2 + 0.6 * s, 0.3 + 0.1 * np.sin(np.pi * s)
        beside = np.maximum(np.maximum(0.45 - x, x - 0.55), 0.0)
        self.assertAlmostEqual(min(seen["clearances"]), np.hypot(beside, y - 0.15).min(), delta=2e-3)
        self.assertEqual(seen["problems"], [])
        self.assertTrue(os.path.exists(self.path("my-preview.png")))
        _, _, err = self.call("train", "my.toml", *command_line.settings(), "--set", ROOM, "--out", "b.h5")
        self.assertIn("clearance of demonstration 0: 0.24", err)

    def test_columns_that_are_named_and_a_folder(self):
        os.mkdir(self.path("in"))
        for k in range(5):
            self.record(f"in/r{k}", lambda s, k=k: [200 + 600 * s, 10 * k * (1 - s)], header="when,a,b")
        _, found = self.new("in", "--time", "when", "--position", "a", "b")
        self.assertEqual((found["demonstrations"], found["unit"]), (5, "mm"))
        _, seen, _ = self.preview()
        self.assertEqual(seen["refusals"], [])
        self.assert_refused(self.call("new", "nothing.csv", "--out", "x.toml"), "nothing.csv")
        self.assert_refused(self.call("new", "d0.xyz", "--out", "x.toml"), "d0.xyz", ".csv")
        self.assert_refused(self.call("new", "d0.bag", "--out", "x.toml"), "s2nnds import")
        os.mkdir(self.path("empty"))
        self.assert_refused(self.call("new", "empty", "--out", "x.toml"), "empty")
        self.assertFalse(os.path.exists(self.path("x.toml")))

    def test_what_no_law_can_follow_is_named(self):
        self.record("circle", lambda s: [0.2 * np.cos(2 * np.pi * s), 0.2 * np.sin(2 * np.pi * s)])
        _, found = self.new("circle.csv")
        self.assertEqual(found["problems"], [])  # a phase is proposed
        position = ("--set", 'data.state="position"')
        _, seen, _ = self.preview(*position)
        self.assertIn("ends where it starts", seen["problems"][0])
        # Training says so first, whatever else is wrong.
        code, _, err = self.call("train", "my.toml", *position, "--set", 'problem.unsafe={ type = "ball", center = [9.0, 0.0], radius = 0.1 }')
        self.assertEqual(code, 2, err)
        self.assertIn("ends where it starts", " ".join(err.splitlines()[:-1]))
        self.assertIn("no points in the workspace", err.splitlines()[-1])
        self.record("loop", lambda s: [(3 * s - 1.5) ** 3 - (3 * s - 1.5) + 2 * s, 1 - (3 * s - 1.5) ** 2])
        self.new("loop.csv")
        _, seen, _ = self.preview(*position)
        self.assertIn("it crosses itself", " ".join(seen["problems"]))
        self.record("there", lambda s: [s, 0.3 * s * (1 - s)])
        self.record("back", lambda s: [1 - s, 0.3 * s * (1 - s)])
        out, found = self.new("there.csv", "back.csv")
        self.assertIn("demonstrations 0 and 1 pass", " ".join(found["problems"]))
        # Their goals differ as well: it says so, and what was done about it.
        self.assertIn("data.goal", " ".join(found["problems"]))
        with open(self.path("my.toml"), encoding="utf-8") as file:
            text = file.read()
        self.assertIn('goal = "each"', text)
        self.assertIn("every demonstration is moved to end there, by 0.5 m", out)
        # The examples in its comments lie where the demonstrations have been moved to.
        with open(self.path("my.toml"), "w", encoding="utf-8") as file:
            file.write(text.replace("# initial =", "initial =").replace("# bounds =", "bounds ="))
        self.preview()

    def test_obstacles_in_the_way_are_named(self):
        self.reaches()
        self.new("d0.csv", "d1.csv", "d2.csv")
        wall = 'problem.unsafe={ type = "box", lower = [0.5, -5.0], upper = [0.55, 5.0] }'
        _, seen, _ = self.preview("--set", wall)
        self.assertIn("passes through the obstacle", seen["problems"][0])
        self.assertIn("cuts the goal off from every start", " ".join(seen["problems"]))
        self.assertEqual(seen["clearances"], [0, 0, 0])
        for unsafe, *expected in (
            ('{ type = "ball", center = [300.0, 400.0], radius = 40.0 }', "no points in the workspace", "(0.8, 0.3) m"),
            ('{ type = "ball", center = [0.8, 0.3], radius = 0.1 }', "covers the goal"),
            ('{ type = "ball", center = [0.2, 0.3], radius = 0.05 }', "problem.initial", "meets the unsafe set"),
        ):
            _, seen, err = self.preview("--set", f"problem.unsafe={unsafe}", code=2)
            for word in expected:
                self.assertIn(word, seen["refusals"][0])
                self.assertIn(word, err)
            self.assertTrue(os.path.exists(self.path("my-preview.png")))
            os.remove(self.path("my-preview.png"))

        # Training does not begin with it.
        refused = self.call("train", "my.toml", "--data", ".", "--set", wall, "--out", self.path("no.h5"))
        self.assert_refused((refused[0], refused[1], refused[2].strip().splitlines()[-1] + "\n"), "cuts the goal off")
        self.assertFalse(os.path.exists(self.path("no.h5")))

    def test_two_ways_round_an_obstacle_are_named(self):
        self.record("up", lambda s: [s, 0.8 * s * (1 - s)])
        self.record("down", lambda s: [s, -0.8 * s * (1 - s)])
        self.new("up.csv", "down.csv")
        ball = 'problem.unsafe={ type = "ball", center = [0.5, 0.0], radius = 0.05 }'
        _, seen, _ = self.preview("--set", ball)
        self.assertIn("demonstrations 0 and 1 start together and pass the obstacle", " ".join(seen["problems"]))

    def test_three_and_more_dimensions(self):
        for n in (3, 4):
            names = ",".join(["time", *(f"q{i + 1}" for i in range(n))])
            self.record("d", lambda s, n=n: [0.1 * (i + 1) * s for i in range(n)], header=names)
            self.new("d.csv")
            self.preview("--set", f'problem.unsafe={{ type = "ball", center = {[0.3] * n}, radius = 0.02 }}')
            self.assertTrue(os.path.exists(self.path("my-preview.png")))


if __name__ == "__main__":
    command_line.main()
