#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A user's recordings far from their origin, in mm and in m: what goes in and comes out is in their unit and frame."""

import json
import os

import command_line
import numpy as np
from command_line import ProgramTest, settings
from s2nnds.run import Run

# Where the motion ends and how large it is, in the unit.
MILLIMETRES = {"unit": "mm", "goal": (5000.0, -2000.0), "size": 400.0}
METRES = {"unit": "m", "goal": (5.0, -2.0), "size": 0.4}

CONFIG = """name = "far"

[data]
source = "csv"
files = {files}
unit = "{unit}"
frame_name = "base_link"
test = [2]
{data}

[problem]
{problem}
"""


def place(kind, x, y):
    """A point of the motion's own picture, where the goal is (0, 0) and the motion starts at (-1, 0)."""
    return [kind["goal"][0] + kind["size"] * x, kind["goal"][1] + kind["size"] * y]


def write(folder, kind, data="", problem=None, ends=(0.0, 0.01, -0.01), name="far"):
    """Three demonstrations that end at `ends` beside the goal, and a configuration with a ball above the motion."""
    for k, end in enumerate(ends):
        u = np.linspace(0.0, 1.0, 120)
        s = u**3 * (10 + u * (6 * u - 15))
        x, y = s - 1, 0.4 * np.sin(np.pi * s) + 0.05 * k * (1 - s) + end
        rows = zip(3.0 * u, *place(kind, x, y))
        with open(os.path.join(folder, f"d{k}.csv"), "w", encoding="utf-8") as file:
            file.write("time,x,y\n" + "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows))
    ball = f'unsafe = {{ type = "ball", center = {place(kind, -0.5, 0.8)}, radius = {0.1 * kind["size"]:g} }}'
    with open(os.path.join(folder, name + ".toml"), "w", encoding="utf-8") as file:
        problem = ball if problem is None else problem
        files = [os.path.join(folder, f"d{k}.csv") for k in range(len(ends))]
        file.write(CONFIG.format(files=files, unit=kind["unit"], data=data, problem=problem))


class FrameTest(ProgramTest):
    def write(self, kind, **options):
        write(self.folder, kind, **options)

    def train(self, *words):
        return self.call("train", "far.toml", *settings(), "--data", ".", "--threads", 1, "--out", "far.h5", *words)

    def test_reports_speak_the_users_unit(self):
        for kind in (MILLIMETRES, METRES):
            with self.subTest(unit=kind["unit"]):
                self.write(kind)
                code, out, err = self.train("--json")
                self.assertIn(code, (0, 3), err)
                unit = kind["unit"]
                goal = f"({kind['goal'][0]:g}, {kind['goal'][1]:g}) {unit}"
                self.assertIn(f"goal {goal} in base_link; demonstrations end 0, ", err)
                self.assertIn(f"1 normalised = {kind['size']:.4g} {unit} (length)", err)
                for words in (goal, f"radius {0.1 * kind['size']:g} ({unit})", f"velocity, RMS [{unit}/s]", f"{unit}^2"):
                    self.assertIn(words, out)
                text, summary = out[: out.index("{")], json.loads(out.splitlines()[-1])
                self.assertNotIn("normalised", text)
                self.assertEqual(summary["problem"]["frame"], "data")
                about = summary["in_unit"]
                np.testing.assert_allclose(about["goal"], kind["goal"])
                np.testing.assert_allclose(about["workspace_upper"], place(kind, 1.25, 1.25), rtol=1e-6)
                self.assertAlmostEqual(about["safe_area"] / kind["size"] ** 2, summary["safe_area"], places=5)
                code, out, err = self.call("info", "far.h5", "--all")
                self.assertEqual((code, err), (0, ""))
                self.assertIn("base_link", out)
                # What was stored is enough to go on with.
                code, out, err = self.call("evaluate", "far.h5", "--splits", "test")
                self.assertIn("demonstration 2 (test): velocity RMS ", out)

    def test_the_run_holds_both_frames(self):
        self.write(MILLIMETRES)
        code, _, err = self.train()
        self.assertIn(code, (0, 3), err)
        run = Run(self.path("far.h5"))
        np.testing.assert_allclose(run.data.goal, MILLIMETRES["goal"], rtol=1e-12)
        self.assertEqual((run.data.frame_name, run.problem.frame), ("base_link", "data"))
        inside = run.data.to_normalized(place(MILLIMETRES, -0.5, 0.8))
        i, j = (int(np.argmin(np.abs(axis - at))) for axis, at in zip(run.grid.axes, inside))
        self.assertLess(run.grid.unsafe[i, j], 0.0)
        # The motions as drawn lie where the robot was.
        shown = run.in_data_unit()
        np.testing.assert_array_equal(shown.data.demonstrations[1].position, run.data.demonstrations[1].position)

    def test_the_same_problem_can_be_written_normalised(self):
        self.write(METRES)
        code, out, err = self.train("--json")
        self.assertIn(code, (0, 3), err)
        run = Run(self.path("far.h5"))
        ball = run.data.to_normalized(place(METRES, -0.5, 0.8))
        radius = 0.1 * METRES["size"] / run.data.position_scale
        self.write(METRES, problem=f'frame = "normalised"\nunsafe = {{ type = "ball", center = {ball.tolist()}, radius = {radius} }}')
        code, _, err = self.train()
        self.assertIn(code, (0, 3), err)
        again = Run(self.path("far.h5"))
        x = run.data.to_data(np.random.default_rng(1).uniform(-1.2, 1.2, (200, 2)))
        # Sets equal but for rounding: a sample or two may fall on the other side of a boundary.
        self.assertLess(np.abs(run.velocity(x) - again.velocity(x)).max(), 0.05 * run.data.velocity_scale)
        self.assertTrue(again.problem.unsafe.startswith("ball centre (-0."))

    def test_bounds_are_the_workspace(self):
        lower, upper = place(METRES, -1.2, -0.3), place(METRES, 0.3, 0.9)
        ball = f'{{ type = "ball", center = {place(METRES, -0.5, 0.75)}, radius = 0.04 }}'
        self.write(METRES, problem=f"bounds = {{ lower = {lower}, upper = {upper} }}\nunsafe = {ball}")
        code, out, err = self.train()
        self.assertIn(code, (0, 3), err)
        run = Run(self.path("far.h5"))
        np.testing.assert_allclose(run.data.to_data(run.problem.workspace_lower), lower)
        np.testing.assert_allclose(run.data.to_data(run.problem.workspace_upper), upper)
        code, out, err = self.call("plot", "far.h5", "--out", "figures")
        self.assertEqual((code, err), (0, ""))

    def test_errors_speak_the_users_unit(self):
        far = f'unsafe = {{ type = "ball", center = {place(MILLIMETRES, 3.0, 0.0)}, radius = 40.0 }}'
        self.write(MILLIMETRES, problem=far)
        self.assert_refused(self.train(), "problem.unsafe", "no points in the workspace", "(4500, -2500) mm", "(5000, -2000) mm")
        on = f'unsafe = {{ type = "ball", center = {place(MILLIMETRES, 0.0, 0.0)}, radius = 40.0 }}'
        self.write(MILLIMETRES, problem=on)
        self.assert_refused(self.train(), "covers the goal", "(5000, -2000) mm")

    def test_ends_far_apart_are_a_choice(self):
        self.write(METRES, ends=(0.0, 0.5, 0.0))
        refused = self.train()
        self.assert_refused(refused, "demonstration 1 ends", "m from the goal", "of the motion's extent", '"each"', "data.use")
        code, _, err = self.train("--set", 'data.goal="each"')
        self.assertIn(code, (0, 3), err)
        self.assertIn("each is moved to end there", err)
        self.assert_refused(self.train("--set", "data.goal=[5.0]"), "data.goal", "1 coordinates", "2")
        self.assert_refused(self.train("--set", 'data.goal="last"'), "data.goal", "mean, each")
        self.write(METRES, data="goal = [5.0, -2.0]")
        code, _, err = self.train()
        self.assertIn(code, (0, 3), err)
        self.assertIn("goal (5, -2) m", err)


if __name__ == "__main__":
    command_line.main()
