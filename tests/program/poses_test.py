#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Poses from recordings to certificates and exports: what is proved of an orientation, what voids it, and that the C++
header, ONNX and Python turn alike. Joints: unwrapped, and refused outside of their limits."""

import json
import os
import shutil
import subprocess
import unittest

import command_line
import h5py
import numpy as np
from command_line import PROJECT, ProgramTest, write_network
from s2nnds.run import Run, angles_between

POSES = os.path.join(PROJECT, "experiments/poses")
POUR = os.path.join(PROJECT, "experiments/configs/poses/pour.toml")
# Beside the motion, where networks written by hand are right.
FAR = {
    "problem.unsafe": '{ type = "ball", center = [0.55, 0.2, 0.68], radius = 0.01 }',
    "problem.tool": "{ start = [0, 0, 0], end = [0, 0, 0.006], radius = 0.004 }",
    "evaluation.area_cells": 8,
    "evaluation.grid_points": 11,
    "verification.method": '"sampled"',
}

DRIVER = """
#include "{folder}/policy.h"
#include <cstdio>
namespace policy = policy_policy;
int main() {{
  double s[policy::dimension + 4], v[policy::dimension], omega[3];
  for (;;) {{
    for (double& value : s) {{
      if (std::scanf("%lf", &value) != 1) return 0;
    }}
    policy::velocity(s, s + policy::dimension, v, omega);
    for (double value : v) std::printf("%.17g ", value);
    std::printf("%.17g %.17g %.17g\\n", omega[0], omega[1], omega[2]);
  }}
}}
"""


def interpret_onnx(model, inputs):
    """name -> output of a model that has no operators but these, by their definitions."""
    from onnx import helper, numpy_helper

    values = {tensor.name: numpy_helper.to_array(tensor) for tensor in model.graph.initializer} | inputs
    operators = {
        "Abs": np.abs,
        "Add": np.add,
        "And": np.logical_and,
        "Atan": np.arctan,
        "Cast": lambda a, to: a.astype({1: np.float32, 9: np.bool_, 11: np.float64}[to]),
        "Div": np.divide,
        "Gather": lambda a, columns, axis: np.take(a, columns, axis=axis),
        "Gemm": lambda a, w, b=0.0, transB=1: a @ w.T + b,
        "GreaterOrEqual": np.greater_equal,
        "Less": np.less,
        "LessOrEqual": np.less_equal,
        "MatMul": np.matmul,
        "Mul": np.multiply,
        "ReduceMin": lambda a, axes, keepdims: a.min(tuple(axes), keepdims=bool(keepdims)),
        "ReduceSum": lambda a, axes, keepdims: a.sum(tuple(axes), keepdims=bool(keepdims)),
        "Sin": np.sin,
        "Softplus": lambda a: np.logaddexp(0, a),
        "Sqrt": np.sqrt,
        "Squeeze": lambda a, axes: a.squeeze(tuple(axes)),
        "Sub": np.subtract,
        "Tanh": np.tanh,
        "Where": np.where,
    }
    with np.errstate(divide="ignore", invalid="ignore"):
        for node in model.graph.node:
            options = {attribute.name: helper.get_attribute_value(attribute) for attribute in node.attribute}
            arguments = [values[name] for name in node.input]
            values[node.output[0]] = operators[node.op_type](*arguments, **options)
    return {output.name: values[output.name] for output in model.graph.output}


class PosesTest(ProgramTest):
    stored = {}  # by the turn of the tool

    def pose_run(self, name="run.h5", turn=0):
        """A small run whose position networks meet every condition by hand: f = -x, V = 1.05 |x|^2, B a soft cube."""
        if turn not in PosesTest.stored:
            PosesTest.stored[turn] = os.path.join(self.store, f"pose_{turn}.h5")
            words = command_line.settings(FAR | {"problem.tool.turn": turn, "training.rounds": 2})
            code, _, err = self.call("train", POUR, "--data", POSES, *words, "--threads", 1, "--out", PosesTest.stored[turn])
            self.assertIn(code, (0, 3), err)
        path = shutil.copyfile(PosesTest.stored[turn], self.path(name))
        k, c, eye, none = 20.0, np.array([0.7, 1.08, 0.7]), np.eye(3), np.zeros(3)
        with h5py.File(path, "r+") as file:
            write_network(file, "f", [(-eye, none, "identity")], "zero_at_origin")
            write_network(file, "V", [(eye, none, "identity")], "squared_norm", 0.05)
            sides = np.vstack([k * eye, -k * eye])
            write_network(file, "B", [(sides, -k * np.concatenate([c, c]), "softplus"), (np.ones((1, 6)), [-0.4], "identity")])
            file["certificate"].attrs["weight_hash"] = ""
            del file["certificate/conditions"]
            file.create_group("certificate/conditions", track_order=True)
        return path

    def proved(self, name="run.h5"):
        path = self.pose_run(name)
        code, out, err = self.call("verify", path, "--method", "proof", "--json")
        self.assertEqual(code, 0, out + err)
        return path, json.loads(out.splitlines()[-1])

    def test_the_orientation_is_proved_and_said_exactly(self):
        path, found = self.proved()
        self.assertEqual(found["guarantee"], "invariant")
        turning = found["orientation"]
        self.assertTrue(turning["proved"])
        self.assertLess(turning["bound_degrees"] + turning["initial_error_degrees"], 180.0)
        for words in ("Excluded are starts with a larger |e|", "e fall as exp(-", "degrees at the start stays below 180 degrees",
                      "q_goal (xyzw) is ("):
            self.assertIn(words, found["statement"])
        self.assertTrue(turning["tool_clear"])
        self.assertIn("The tool, a capsule from (0, 0, 0) to (0, 0, 0.006) of radius 0.004 m in the frame that turns, touches "
                      "nothing of the obstacle", found["statement"])
        run = Run(path)
        # The bound holds at random points of the safe set.
        z = np.random.default_rng(1).uniform(-1.25, 1.25, (20000, 3))
        psi = np.linalg.norm(run.orientation.psi(z[run.B(z) <= 0]), axis=1)
        self.assertLess(np.degrees(psi.max()), turning["bound_degrees"])
        # Every demonstration's start is covered.
        for k in run.data.train:
            d = run.data.demonstrations[k]
            target = run.orientation.psi(run.data.to_normalized(d.position[:1]))
            from s2nnds.run import rotation_vectors
            error = np.linalg.norm(rotation_vectors(run.data.goal_orientation, d.orientation[:1]) - target)
            self.assertLess(error, run.orientation.initial_error)

    def test_another_psi_or_rate_voids_the_certificate(self):
        for item, change in (
            ("weight", lambda g: g["weight_1"].write_direct(g["weight_1"][()] * (1 + 1e-12))),
            ("rate", lambda g: g.attrs.modify("rate", 9.0)),
            ("initial_error", lambda g: g.attrs.modify("initial_error", 0.9)),
        ):
            path, _ = self.proved(f"{item}.h5")
            with h5py.File(path, "r+") as file:
                change(file["networks/psi"])
            self.assert_refused(self.call("info", path), "other than those that its certificate speaks of")
            with self.assertRaisesRegex(Exception, "other than those that its certificate speaks of"):
                Run(path)

    def test_a_wide_psi_is_not_proved(self):
        path = self.pose_run()
        with h5py.File(path, "r+") as file:
            weight = file["networks/psi/weight_1"]
            weight[...] = 20.0 * weight[()]
        code, out, err = self.call("verify", path, "--method", "proof", "--json")
        self.assertEqual(code, 3, out + err)
        found = json.loads(out.splitlines()[-1])
        self.assertEqual(found["guarantee"], "invariant")
        self.assertFalse(found["orientation"]["proved"])
        self.assertIn("Nothing is guaranteed of the orientation: psi turns too far", found["statement"])

    def test_a_tool_that_may_turn_farther_than_said_is_not_vouched_for(self):
        code, out, err = self.call("verify", self.pose_run(turn=5), "--method", "proof", "--json")
        self.assertEqual(code, 3, out + err)
        found = json.loads(out.splitlines()[-1])
        self.assertEqual(found["guarantee"], "invariant")
        self.assertTrue(found["orientation"]["proved"])
        self.assertFalse(found["orientation"]["tool_clear"])
        self.assertIn("Nothing is guaranteed of the tool", found["statement"])

    def test_formats_turn_alike(self):
        path, _ = self.proved()
        run, rng = Run(path), np.random.default_rng(2)
        x = run.data.to_data(rng.uniform(-1.2, 1.2, (300, 3)))
        q = rng.standard_normal((300, 4))
        q /= np.linalg.norm(q, axis=1, keepdims=True)
        near = run.data.goal_orientation[[1, 2, 3, 0]]
        q[:5] = near + 1e-9 * rng.standard_normal((5, 4))
        v, omega = run.pose_velocity(x, q)
        unit = max(1.0, np.abs(omega).max())
        code, _, err = self.call("export", path, "--out", self.path("policy.h"), "--precision", "double")
        self.assertEqual((code, err), (0, ""))
        with open(self.path("driver.cpp"), "w", encoding="utf-8") as file:
            file.write(DRIVER.format(folder=self.folder))
        subprocess.run(["g++", "-std=c++17", "-O2", self.path("driver.cpp"), "-o", self.path("driver")], check=True)
        text = "\n".join(" ".join(f"{value:.17g}" for value in row) for row in np.hstack([x, q]))
        done = subprocess.run([self.path("driver")], input=text, capture_output=True, text=True, check=True)
        rows = np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])
        print(f"  header: v {np.abs(rows[:, :3] - v).max():.1e} omega {np.abs(rows[:, 3:] - omega).max() / unit:.1e}")
        np.testing.assert_allclose(rows[:, :3], v, atol=1e-9)
        self.assertLess(np.abs(rows[:, 3:] - omega).max() / unit, 1e-9)
        code, _, err = self.call("export", path, "--format", "onnx", "--out", self.path("policy.onnx"))
        self.assertEqual((code, err), (0, ""))
        import onnx

        model = onnx.load(self.path("policy.onnx"))
        onnx.checker.check_model(model, full_check=True)
        inputs = {"position": x, "orientation": q}
        answers = {"its definition": interpret_onnx(model, inputs)}
        try:
            import onnxruntime

            session = onnxruntime.InferenceSession(self.path("policy.onnx"), providers=["CPUExecutionProvider"])
            names = [output.name for output in session.get_outputs()]
            answers["onnxruntime"] = dict(zip(names, session.run(names, inputs)))
        except ImportError as error:
            print(f"  no ONNX runtime: {error}")
        for name, found in answers.items():
            off = np.abs(found["angular_velocity"] - omega).max() / unit
            print(f"  onnx by {name}: v {np.abs(found['velocity'] - v).max():.1e} omega {off:.1e}")
            self.assertLess(np.abs(found["velocity"] - v).max() / run.data.velocity_scale, 1e-6)
            self.assertLess(off, 1e-6)
        about = {entry.key: entry.value for entry in model.metadata_props}
        self.assertEqual((about["quaternion_order"], about["orientation_proved"]), ("xyzw", "1"))

    def test_runs_hold_orientations_and_their_errors(self):
        path = self.pose_run()
        code, out, err = self.call("evaluate", path, "--json")
        self.assertIn(code, (0, 3), err)
        figures = json.loads(out.splitlines()[-1])
        for key in ("orientation_mean_train", "orientation_largest_train", "orientation_mean_test"):
            self.assertGreater(figures[key], 0.0)
            self.assertLess(figures[key], 90.0)
        self.assertIn("orientation, mean [degrees]", out)
        run = Run(path)
        self.assertEqual(run.data.quaternion_order, "xyzw")
        for rollout in run.rollouts:
            self.assertEqual(rollout.orientation.shape, (len(rollout.time), 4))
            if rollout.stop == "reached_goal":
                self.assertLess(angles_between(rollout.orientation[-1:], run.data.goal_orientation[None])[0], 10.0)
        for d in run.data.demonstrations:
            np.testing.assert_allclose(np.linalg.norm(d.orientation, axis=1), 1.0, atol=1e-12)

    def test_new_proposes_poses(self):
        code, out, err = self.call("new", POSES, "--out", self.path("pour.toml"))
        self.assertEqual(code, 0, err)
        self.assertIn("quaternions xyzw, turned by up to", out)
        with open(self.path("pour.toml"), encoding="utf-8") as file:
            text = file.read()
        self.assertIn('state = "pose"', text)
        self.assertIn('quaternion_order = "xyzw"', text)
        code, out, err = self.call("preview", self.path("pour.toml"))
        self.assertEqual(code, 0, err)

    def test_new_leaves_bad_orientations_out_and_says_so(self):
        for k in range(2):
            with open(os.path.join(POSES, f"pour_{k}.csv"), encoding="utf-8") as file:
                lines = file.read().splitlines()
            if k == 1:
                lines[30] = ",".join(lines[30].split(",")[:4] + ["0", "0", "0", "0"])
            with open(self.path(f"pour_{k}.csv"), "w", encoding="utf-8") as file:
                file.write("\n".join(lines) + "\n")
        code, out, err = self.call("new", self.path("pour_0.csv"), self.path("pour_1.csv"), "--out", self.path("a.toml"))
        self.assertEqual(code, 0, err)
        self.assertIn("orientations are left out: ", out)
        self.assertIn("pour_1.csv:31: found a quaternion of norm 0", out)
        with open(self.path("a.toml"), encoding="utf-8") as file:
            self.assertNotIn("pose", file.read().split("[data]")[1])

    def test_joints_are_unwrapped_and_kept_within_their_limits(self):
        script = os.path.join(PROJECT, "experiments/walkthroughs/make_recordings.py")
        subprocess.run([command_line.sys.executable, script, "joints", self.path("in")], check=True)
        config = self.path("joints.toml")
        text = """
name = "joints"
[data]
source = "csv"
files = ["reach_*.csv"]
state = "joints"
[problem]
bounds = { lower = [2.0, -2.0, -1.0, -1.5], upper = [5.0, 1.5, 2.0, 1.5] }
[verification]
method = "conformal"
"""
        with open(config, "w", encoding="utf-8") as file:
            file.write(text)
        code, out, err = self.call("preview", config, "--data", self.path("in"))
        self.assertEqual(code, 0, err + out)
        self.assertIn("joint angles unwrapped: 5 jump(s)", out)
        with open(config, "w", encoding="utf-8") as file:
            file.write(text.replace("upper = [5.0,", "upper = [3.9,").replace("lower = [2.0, -2.0", "lower = [2.0, -0.55"))
        code, _, err = self.call("train", config, "--data", self.path("in"))
        self.assertEqual(code, 2)
        self.assertIn("outside of the workspace", err)
        self.assertRegex(err, r"sample \d+ \(line \d+ of its file\)")


if __name__ == "__main__":
    command_line.main()
