#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""One certificate for every displacement of an obstacle: the command, the exported header, and motions that try to break it."""

import json
import os
import subprocess
import unittest

import command_line
import numpy as np
from command_line import PROJECT, SINE, ProgramTest

CENTER, RADIUS = np.array([-0.32, 0.22]), 0.12  # of the obstacle of SINE, normalised
MOTIONS = int(os.environ.get("S2NNDS_MOTIONS", "4000"))


class RangeTest(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.run_file = os.path.join(cls.store, "sine.h5")
        code, _, err = command_line.call("train", SINE, "--out", cls.run_file, "--until", "certified", "--set",
                                         "evaluation.area_cells=20", cwd=cls.store)
        assert code == 0, err

    def range(self, *words):
        code, out, err = self.call("range", self.run_file, *words, "--json")
        self.assertEqual(code, 0, err)
        lines = out.splitlines()
        return json.loads(lines[-1])["range"], " ".join(" ".join(lines[:-1]).split())

    def refusal(self, *words, command="range"):
        code, _, err = self.call(command, *words)
        self.assertEqual(code, 2, err)
        self.assertEqual(len(err.strip().splitlines()), 1, err)
        return err

    def test_says_how_far_the_obstacle_may_be_displaced(self):
        found, text = self.range()
        self.assertIn("Certified for every displacement p of the obstacle (ball centre (-0.32, 0.22) radius 0.12)", text)
        self.assertIn("converges to the goal", text)
        self.assertEqual(found["statement"], " ".join(found["statement"].split()))
        self.assertEqual(found["limit"], "the goal")
        self.assertGreater(found["arrived"], 0)
        self.assertEqual(found["arrived"], found["motions"])
        self.assertGreater(found["deviation"]["mean"], 0.0)
        self.assertGreaterEqual(found["inner"], RADIUS * found["outer"] / np.hypot(*CENTER))
        self.assertLessEqual(found["radius"], 0.8 * 0.75 * (found["outer"] - found["inner"]))
        before = os.path.getmtime(self.run_file)
        small, _ = self.range("--stretch", 0.4)
        self.assertAlmostEqual(small["radius"], 0.5 * found["radius"], places=9)
        self.assertGreater(small["margin"], found["margin"])
        clipped, _ = self.range("--within", 0.3 * found["radius"], 0.01 * found["radius"])
        self.assertEqual(len(clipped["half_sizes"]), 2)
        self.assertLess(clipped["stretch"], 0.3)
        self.assertEqual(os.path.getmtime(self.run_file), before)

    def test_refuses_in_one_line(self):
        run = self.run_file
        self.assertIn("--obstacle 3, expected one of 0 to 0", self.refusal(run, "--obstacle", 3))
        self.assertIn('the obstacle "left"', self.refusal(run, "--obstacle", "left"))
        self.assertIn("stretch of 1", self.refusal(run, "--stretch", 1))
        self.assertIn("--within with 3 numbers", self.refusal(run, "--within", 1, 2, 3))
        self.assertIn("--within", self.refusal(run, "--within", -1))
        self.assertIn("found onnx and a range of scenes",
                      self.refusal(run, "--format", "onnx", "--range", "all", "--out", self.path("p.onnx"), command="export"))
        self.assertFalse(os.path.exists(self.path("p.onnx")))
        weak = self.trained()
        self.assertIn("expected invariant", self.refusal(weak))

    def test_adapt_says_when_it_is_not_needed(self):
        for center, offered in (([-0.3, 0.22], True), ([-0.9, 0.9], False)):
            code, _, err = self.call("adapt", self.run_file, "--set", f"problem.unsafe.center={center}", "--out",
                                     self.path("new.h5"))
            self.assertIn(code, (0, 3), err)
            self.assertEqual("need no training" in err, offered, err)

    def test_header_keeps_motions_off_the_displaced_obstacle(self):
        header = os.path.join(self.folder, "policy.h")
        code, out, err = self.call("export", self.run_file, "--range", "all", "--out", header)
        self.assertEqual(code, 0, err)
        self.assertIn("Certified for every displacement", out)
        program = self.path("attack")
        subprocess.run(["g++", "-std=c++17", "-O3", "-march=native", "-Wall", "-Wextra", "-Werror", "-I", self.folder,
                        '-DPOLICY_HEADER="policy.h"', "-DPOLICY_NAMESPACE=policy_policy",
                        os.path.join(PROJECT, "tests/deployment/displaced_motions.cpp"), "-o", program], check=True)
        from s2nnds import Run

        run = Run(self.run_file)
        center = run.data.to_data(CENTER)
        scale = run.data.position_scale

        def attack(motions, push):
            words = [motions, *center, RADIUS * scale, 0.02 * scale, push]
            return subprocess.run([program, *map(str, words)], check=True, capture_output=True, text=True).stdout.split()

        answer = attack(MOTIONS, 0)
        touched, left, arrived, motions = map(int, answer[:4])
        self.assertEqual((touched, left, arrived, motions), (0, 0, MOTIONS, MOTIONS))
        self.assertEqual(attack(MOTIONS // 4, 0.999)[:2], ["0", "0"])
        self.assertGreater(int(attack(1000, 100)[1]), 0)  # the attack is one
        self.assertLess(float(answer[4]), 20000.0)  # loaded machines; some 500 ns otherwise

    def test_python_answers_as_the_header(self):
        from s2nnds import Run

        run = Run(self.run_file)
        scene = run.scene_range(program=command_line.PROGRAM)
        found, _ = self.range()
        self.assertEqual(scene.radius, found["radius"])
        random = np.random.default_rng(3)
        x = run.data.to_data(random.uniform(-1.2, 1.2, (500, 2)))
        np.testing.assert_array_equal(scene.velocity(x, [0.0, 0.0]), run.velocity(x))
        p = 0.99 * scene.radius * np.array([0.6, -0.8])
        y = scene.before(x, p)
        np.testing.assert_allclose(scene.after(y, p), x, atol=1e-11 * run.data.position_scale)
        np.testing.assert_allclose(scene.barrier(x, p), run.barrier(y), atol=1e-12)
        h = 1e-6 * run.data.position_scale
        v = run.velocity(y)
        size = np.linalg.norm(v, axis=1, keepdims=True)
        moved = (scene.after(y + h * v / size, p) - scene.after(y - h * v / size, p)) / (2 * h) * size
        np.testing.assert_allclose(scene.velocity(x, p), moved, atol=1e-5 * run.data.velocity_scale)
        rate = np.array([3.0, 1.0])
        np.testing.assert_allclose(scene.velocity(run.data.to_data(CENTER)[None] + p, p, rate)[0],
                                   run.velocity(run.data.to_data(CENTER)[None])[0] + rate, rtol=1e-12)
        with self.assertRaises(ValueError):
            scene.velocity(x, [2 * scene.radius, 0.0])


if __name__ == "__main__":
    command_line.main()
