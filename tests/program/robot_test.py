#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What a robot has of a trained policy: its shield, by Python and the exported header, motions behind the latter, and a
simulated arm that draws the motion."""

import json
import os
import subprocess
import unittest

import command_line
import numpy as np
from command_line import PROJECT, SINE, ProgramTest

# What an arm does wrong, in proportions that all matter for the motion learned here.
SHAPE = {"period": 0.0002, "delay": 0.0004, "position_error": 0.0002, "velocity_error": 0.001,
         "velocity_error_relative": 0.0005}
MODEL = {"unit": '"normalised"', "period": 0.0005, "delay": 0.0005, "position_error": 0.0002, "velocity_error": 0.004,
         "velocity_error_relative": 0.001}


class RobotTest(ProgramTest):
    @classmethod
    def setUpClass(cls):
        from s2nnds import Run

        super().setUpClass()
        cls.ideal, cls.file = (os.path.join(cls.store, name) for name in ("ideal.h5", "shielded.h5"))
        cls.command("train", SINE, "--out", cls.ideal, "--until", "certified", "--set", "evaluation.area_cells=20")
        with open(cls.ideal, "rb") as source, open(cls.file, "wb") as copy:
            copy.write(source.read())
        words = [word for key, value in MODEL.items() for word in ("--set", f"execution.{key}={value}")]
        cls.command("verify", cls.file, "--method", "proof", *words)
        for precision in ("double", "float"):
            cls.command("export", cls.file, "--precision", precision, "--out", os.path.join(cls.store, precision + ".h"))
        cls.run_read = Run(cls.file)

    @classmethod
    def command(cls, *words):
        code, _, err = command_line.call(*words, cwd=cls.store)
        assert code == 0, err

    @staticmethod
    def model(size):
        values = {"unit": '"normalised"', **{key: size * value for key, value in SHAPE.items()}}
        return [word for key, value in values.items() for word in ("--set", f"execution.{key}={value}")]

    def is_certified(self, file, size):
        code, out, err = command_line.call("verify", file, "--method", "proof", "--json", *self.model(size), cwd=self.folder)
        self.assertEqual(code, 0, err)
        return json.loads(out.splitlines()[-1])["execution"]["invariant"]

    def compiled(self, driver, precision):
        program = os.path.join(self.folder, driver + precision)
        subprocess.run(
            ["g++", "-std=c++17", "-O2", "-march=native", "-I", self.store, f'-DPOLICY_HEADER="{precision}.h"',
             f"-DPOLICY_NAMESPACE=policy_{precision}", os.path.join(PROJECT, "tests/deployment", driver + ".cpp"), "-o",
             program],
            check=True,
        )
        return program

    def readings_and_wishes(self, count):
        """All over the workspace and at the edge of the safe set; from far too slow to far too fast."""
        run, random = self.run_read, np.random.default_rng(1)
        x = run.data.to_data(random.uniform(-1.3, 1.3, (count, 2)))
        inside, outside = x[run.barrier(x) < 0.0][: count // 8], x[run.barrier(x) > 0.0][: count // 8]
        many = min(len(inside), len(outside))
        low, high = inside[:many], outside[:many]
        for _ in range(50):
            middle = 0.5 * (low + high)
            is_in = (run.barrier(middle) <= 0.0)[:, None]
            low, high = np.where(is_in, middle, low), np.where(is_in, high, middle)
        x[:many] = low
        wanted = random.normal(size=x.shape) * run.data.velocity_scale * np.exp(random.uniform(-4, 4, (len(x), 1)))
        return x, wanted

    def test_python_and_header_answer_alike(self):
        run = self.run_read
        x, wanted = self.readings_and_wishes(8000)
        x[-1, 0], wanted[-2, 1], wanted[-3] = np.nan, np.inf, 0.0
        v, change = run.shield(x, wanted)
        self.assertTrue(0.2 < np.mean(change > 0.0) < 0.8)
        rows = "\n".join(" ".join(map(repr, row)) for row in np.hstack([x, wanted]).tolist())
        for precision, tolerance in (("double", 1e-11), ("float", 1e-5)):
            out = subprocess.run([self.compiled("shield_values_driver", precision)], input=rows, capture_output=True,
                                 text=True, check=True).stdout
            seen = np.array([line.split() for line in out.splitlines()], dtype=float)
            self.assertEqual(len(seen), len(x))
            np.testing.assert_allclose(seen[:, :2], v, rtol=0, atol=tolerance * np.abs(wanted[:-3]).max())
            np.testing.assert_allclose(seen[:, 2], change, rtol=0, atol=tolerance * np.abs(wanted[:-3]).max())
        single = run.shield(x[0], wanted[0])
        np.testing.assert_allclose(single[0], v[0], rtol=1e-12)  # matrix products of another size round otherwise
        np.testing.assert_allclose(single[1], change[0], rtol=1e-9)

    def test_changes_nothing_inside_nor_where_the_motion_is_wanted(self):
        run = self.run_read
        x, wanted = self.readings_and_wishes(8000)
        safe = run.safe(x)
        own = run.velocity(x)
        v, change = run.shield(x, own)
        self.assertEqual(np.abs(change[safe]).max(), 0.0)
        np.testing.assert_array_equal(v[safe], own[safe])
        fastest = run.data.velocity_scale * run.certificate["execution"]["most_command"]
        inside = (run.barrier(x) < -0.05) & safe
        wanted *= (0.99 * fastest / np.linalg.norm(wanted, axis=1))[:, None]
        v, change = run.shield(x[inside], wanted[inside])
        self.assertGreater(inside.sum(), 1000)
        self.assertEqual(change.max(), 0.0)
        np.testing.assert_array_equal(v, wanted[inside])

    def test_no_motion_leaves_whatever_is_wanted(self):
        data = self.run_read.data
        length, speed = data.position_scale, data.velocity_scale
        model = [MODEL["period"], MODEL["delay"], length * MODEL["position_error"], speed * MODEL["velocity_error"],
                 MODEL["velocity_error_relative"]]
        out = subprocess.run([self.compiled("shield_driver", "float"), "3000", *map(str, model), "1", "5"],
                             capture_output=True, text=True, check=True).stdout.split()
        left, untouched, changed = map(int, out[:3])
        self.assertEqual(left, 0)
        self.assertGreater(untouched, 1000)
        self.assertGreater(changed, 1000)
        self.assertEqual(float(out[3]), 0.0)  # of the motion's own velocity
        self.assertEqual(int(out[6]), 0)  # allocations

    def test_bad_figures_are_refused(self):
        file = self.path("bad.h5")
        with open(self.ideal, "rb") as source, open(file, "wb") as copy:
            copy.write(source.read())
        before = command_line.contents(file)
        for words in ("period=-0.001", "delay=nan", "lag=-1", "position_error=-0.1", "velocity_error=inf",
                      "velocity_error_relative=1", "speed=0", "speed=-1", "extent=-1", 'unit="inch"', 'preset="arm"'):
            key = words.split("=")[0]
            self.assert_refused(self.call("verify", file, "--method", "proof", "--set", f"execution.{words}"),
                                f"execution.{key}: expected")
        self.assert_refused(self.call("verify", file, "--method", "proof", "--set", "execution.pace=1"), "execution.pace")
        self.assert_refused(self.call("verify", file, "--method", "proof", "--speed", "auto"), "execution model")
        self.assert_refused(self.call("verify", file, "--method", "sampled", "--speed", "auto", "--set", "execution.lag=1"),
                            "--method proof")
        self.assertEqual(str(command_line.contents(file)), str(before))

    def test_the_summary_says_what_is_certified_as_executed(self):
        file = self.path("said.h5")
        with open(self.ideal, "rb") as source, open(file, "wb") as copy:
            copy.write(source.read())
        code, out, err = self.call("verify", file, "--method", "proof", "--speed", "auto", *self.model(0.3))
        self.assertEqual(code, 0, err)
        self.assertRegex(out, r"certified from \S+ to \S+ times the demonstrated speed \(up to \S+ \S*/s")
        self.assertRegex(out, r"\n  as executed +stays in the safe set; ")
        self.assertRegex(out, r"\n  shield +")
        self.assertRegex(out, r"\n  speed +\S+ to \S+ times the demonstrated one, up to \S+ \S*/s")
        code, out, err = self.call("verify", file, "--method", "proof", "--speed", "auto", "--set", "execution.delay=1e9")
        self.assertEqual(code, 0, err)
        self.assertIn("no speed is certified", out)
        self.assertRegex(out, r"\n  as executed +NOT certified\n  readings may be \S+ normalised units away")
        code, out, err = self.call("info", file, "--all")
        self.assertEqual(code, 0, err)
        self.assertIn("the motion is NOT certified", " ".join(out.split()))

    def test_no_executed_motion_leaves_and_four_times_the_errors_break_some(self):
        """Of the largest model of SHAPE that is certified; as many motions as S2NNDS_MOTIONS says."""
        file = self.path("limit.h5")
        with open(self.ideal, "rb") as source, open(file, "wb") as copy:
            copy.write(source.read())
        low, high = 0.0, 64.0
        while high - low > 0.05 * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.is_certified(file, middle) else (low, middle)
        self.assertGreater(low, 0.5)
        self.assertTrue(self.is_certified(file, low))
        self.command("export", file, "--precision", "float", "--out", os.path.join(self.store, "limit.h"))
        data = self.run_read.data
        units = {"position_error": data.position_scale, "velocity_error": data.velocity_scale}
        words = [repr(low * value * units.get(key, 1.0)) for key, value in SHAPE.items()]
        driver = self.compiled("motion_driver", "limit")
        for motions, times, leave in ((os.environ.get("S2NNDS_MOTIONS", "3000"), "1", False), ("20000", "4", True)):
            out = subprocess.run([driver, motions, *words, times, "7"], capture_output=True, text=True, check=True).stdout
            self.assertEqual(int(out.split()[0]) > 0, leave, f"{out} of {motions}, {times} times {low} of the shape")

    def test_a_simulated_arm_draws_the_motion(self):
        program = command_line.driver("robot_drawing")
        if not os.path.exists(program):
            self.skipTest("robot_drawing was not built: found no MuJoCo")
        out = self.path("drawing")
        words = [self.file, "--out", out, "--starts", "2", "--edge", "1"]
        done = subprocess.run([program, *words], capture_output=True, text=True, check=False,
                              env=command_line.environment())
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(os.path.join(out, "robot_drawing.json"), encoding="utf-8") as file:
            (drawn,) = json.load(file)["motions"]
        self.assertTrue(1.0 < drawn["mass"] < 10.0)
        self.assertEqual(len(drawn["motions"]), 2 * (3 * 2 + 1))
        plain = [one for one in drawn["motions"]
                 if one["control"] == "feed-forward" and one["scene"] in ("demonstrated", "edge of {B <= 0}")]
        self.assertTrue(all(one["arrived"] and not one["left"] for one in plain))
        self.assertGreater(os.path.getsize(os.path.join(out, "Sine.png")), 10000)
        done = subprocess.run([program, self.path("nothing.h5")], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))

    def test_a_run_without_one_says_so(self):
        from s2nnds import Run

        with self.assertRaisesRegex(ValueError, "^shield: found a run without a certified shield.*$"):
            Run(self.ideal).shield([0.0, 0.0], [1.0, 0.0])
        with self.assertRaisesRegex(ValueError, "expected both"):
            self.run_read.shield([[0.0, 0.0]], [1.0, 0.0])


if __name__ == "__main__":
    command_line.main()
