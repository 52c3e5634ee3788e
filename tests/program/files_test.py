#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What leaves the program: the exported policies against the run file's own networks, and the figures."""

import os
import subprocess

import command_line
import h5py
import numpy as np
import torch
from command_line import ProgramTest
from s2nnds.run import Run


def interpret_onnx(model, x):
    """The outputs of a model that has no operators but these, by their definitions."""
    from onnx import numpy_helper

    values = {tensor.name: numpy_helper.to_array(tensor) for tensor in model.graph.initializer}
    values[model.graph.input[0].name] = x
    operators = {
        "Div": lambda a, b: a / b,
        "Mul": lambda a, b: a * b,
        "Add": lambda a, b: a + b,
        "Sub": lambda a, b: a - b,
        "Gemm": lambda a, w, b=0.0: a @ w.T + b,  # transB = 1
        "Tanh": np.tanh,
        "Sin": np.sin,
        "Sigmoid": lambda a: 1 / (1 + np.exp(-a)),
        "Softplus": lambda a: np.logaddexp(0, a),
        "Elu": lambda a: np.where(a > 0, a, np.expm1(a)),
        "Squeeze": lambda a, axes: a.squeeze(tuple(axes)),
        "ReduceSum": lambda a, axes: a.sum(tuple(axes)),
        "ReduceMin": lambda a: a.min(1),  # axes = [1], keepdims = 0
        "And": lambda a, b: a & b,
        "GreaterOrEqual": lambda a, b: a >= b,
        "LessOrEqual": lambda a, b: a <= b,
    }
    types = {1: np.float32, 9: np.bool_, 11: np.float64}
    for node in model.graph.node:
        if node.op_type == "Cast":
            values[node.output[0]] = values[node.input[0]].astype(types[node.attribute[0].i])
            continue
        values[node.output[0]] = operators[node.op_type](*(values[name] for name in node.input))
    return [values[output.name] for output in model.graph.output]


def run_onnx(path, x):
    try:
        import onnxruntime
    except ImportError:
        return None
    return onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"]).run(None, {"position": x})


class ExportTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.rng = np.random.default_rng(5)

    def export(self, run, *words):
        code, out, err = self.call("export", run, "--format", "torchscript", *words)
        self.assertEqual((code, err), (0, ""), out)

    def assert_same_values(self, path, run, dtype, tolerance):
        policy = torch.jit.load(path)
        if dtype is torch.float64:
            policy = policy.double()
        n = run.dimension
        normalised = self.rng.uniform(run.problem.workspace_lower, run.problem.workspace_upper, (500, n))
        x = torch.as_tensor(run.data.to_data(normalised), dtype=dtype)
        for found, expected, scale in (
            (policy(x), run.f(normalised), run.data.velocity_scale),
            (policy.lyapunov(x), run.V(normalised), 1.0),
            (policy.barrier(x), run.B(normalised), 1.0),
        ):
            self.assertEqual(found.dtype, dtype)
            expected = scale * expected
            self.assertEqual(tuple(found.shape), expected.shape)
            error = np.abs(found.numpy() - expected).max()
            self.assertLess(error, tolerance * max(1.0, np.abs(expected).max()))

    def test_trained_networks_come_back(self):
        path = self.trained()
        self.export(path)
        run = Run(path)
        self.assert_same_values(self.path("run.pt"), run, torch.float32, 1e-5)
        self.assert_same_values(self.path("run.pt"), run, torch.float64, 1e-6)

    def test_other_activations_and_profile(self):
        for changes in (
            {"networks.f.activation": '"sine"', "networks.V.activation": '"softplus"', "networks.B.activation": '"silu"'},
            {"profile": '"paper"'},
        ):
            with self.subTest(changes=changes):
                path = self.trained(changes=changes)
                self.export(path, "--out", self.path("other.pt"))
                self.assert_same_values(self.path("other.pt"), Run(path), torch.float64, 1e-6)

    def test_onnx_computes_the_same(self):
        import onnx

        for changes in ({}, {"networks.f.activation": '"elu"', "networks.V.activation": '"softplus"', "networks.B.activation": '"silu"'},
                        {"profile": '"paper"', "networks.f.activation": '"sine"'}):  # fmt: skip
            with self.subTest(changes=changes):
                path, out = self.trained(changes=changes), self.path("policy.onnx")
                code, _, err = self.call("export", path, "--format", "onnx", "--out", out)
                self.assertEqual((code, err), (0, ""))
                model = onnx.load(out)
                onnx.checker.check_model(model, full_check=True)
                run = Run(path)
                about = {entry.key: entry.value for entry in model.metadata_props}
                self.assertEqual((about["guarantee"], about["unit"]), (run.guarantee, run.data.unit))
                self.assertEqual(about["weight_hash"], run.certificate["weight_hash"])
                self.assertEqual(float(about["position_scale"]), run.data.position_scale)
                normalised = self.rng.uniform(run.problem.workspace_lower, run.problem.workspace_upper, (200, run.dimension))
                x = run.data.to_data(normalised)
                for results in (interpret_onnx(model, x), run_onnx(out, x)):
                    if results is None:
                        continue  # no onnxruntime here
                    np.testing.assert_array_equal(results[3][np.abs(results[2]) > 1e-4], run.safe(x)[np.abs(results[2]) > 1e-4])
                    for found, expected in zip(results, (run.data.velocity_scale * run.f(normalised), run.V(normalised), run.B(normalised))):
                        self.assertEqual(found.shape, expected.shape)
                        self.assertLess(np.abs(found - expected).max(), 1e-4 * max(1.0, np.abs(expected).max()))

    def test_goal_is_an_equilibrium(self):
        path = self.trained()
        self.export(path)
        goal = torch.as_tensor(Run(path).data.goal[None], dtype=torch.float64)
        policy = torch.jit.load(self.path("run.pt")).double()
        self.assertLess(policy(goal).abs().max().item(), 1e-6)
        self.assertLess(policy.lyapunov(goal).abs().max().item(), 1e-12)

    def test_attributes_say_what_is_guaranteed(self):
        path = self.certified()
        code, _, err = self.call("verify", path, "--method", "sampled")
        self.assertEqual(code, 0, err)
        self.export(path)
        run, policy = Run(path), torch.jit.load(self.path("run.pt"))
        self.assertEqual((policy.guarantee, run.guarantee), ("sampled", "sampled"))
        self.assertEqual(policy.weight_hash, run.certificate["weight_hash"])
        self.assertEqual(len(policy.weight_hash), 64)
        self.assertEqual(policy.statement, run.certificate["statement"])
        self.assertEqual((policy.dimension, policy.name, policy.unit), (2, "Sine", "mm"))
        self.assertEqual(policy.position_scale, run.data.position_scale)
        self.assertEqual(policy.velocity_scale, run.data.velocity_scale)
        np.testing.assert_array_equal(policy.goal, run.data.goal)
        corners = [run.data.to_data(run.problem.workspace_lower), run.data.to_data(run.problem.workspace_upper)]
        np.testing.assert_allclose(policy.workspace, np.concatenate(corners), rtol=1e-12)

    def test_safe_is_the_barrier_inside_the_workspace(self):
        path = self.certified()
        self.export(path)
        run, policy = Run(path), torch.jit.load(self.path("run.pt"))
        normalised = self.rng.uniform(-2.0, 2.0, (2000, 2))
        inside = np.all(np.abs(normalised) <= run.problem.workspace_upper, axis=1)
        expected = (run.B(normalised) <= 0.0) & inside
        certain = np.abs(run.B(normalised)) > 1e-3
        safe = policy.safe(torch.as_tensor(run.data.to_data(normalised), dtype=torch.float32)).numpy()
        np.testing.assert_array_equal(safe[certain], expected[certain])
        self.assertTrue(0 < safe.sum() < len(safe))
        # Outside, nothing is safe, whatever B says there.
        with h5py.File(path, "r+") as file:
            command_line.write_network(file, "B", [(np.zeros((1, 2)), [-1.0], "identity")])
        self.export(path, "--out", self.path("always.pt"))
        always = torch.jit.load(self.path("always.pt"))
        x = torch.as_tensor(run.data.to_data(normalised), dtype=torch.float32)
        np.testing.assert_array_equal(always.safe(x).numpy(), inside)


class HeaderTest(ProgramTest):
    """export --format header: the header by itself, compiled with warnings as errors, against the run file's networks."""

    DRIVER = """
#include "{header}"
#include <cstdio>
int main() {{
  double x[{space}::dimension], v[{space}::dimension];
  for (;;) {{
    for (double& value : x) {{
      if (std::scanf("%lf", &value) != 1) return 0;
    }}
    {space}::velocity(x, v);
    for (double value : v) std::printf("%.17g ", value);
    std::printf("%.17g %.17g %d\\n", {space}::lyapunov(x), {space}::barrier(x), int({space}::safe(x)));
  }}
}}
"""

    def answers(self, header, points):
        space = "policy_" + os.path.splitext(header)[0]
        with open(self.path("driver.cpp"), "w", encoding="utf-8") as file:
            file.write(self.DRIVER.format(header=header, space=space))
        warnings = ("-std=c++17", "-Wall", "-Wextra", "-Werror", "-O2", "-march=native")
        subprocess.run(["g++", *warnings, "driver.cpp", "-o", "driver"], cwd=self.folder, check=True)
        text = "\n".join(" ".join(map(repr, map(float, point))) for point in points)
        done = subprocess.run([self.path("driver")], input=text, capture_output=True, text=True, check=True)
        return np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])

    def assert_same_values(self, header, run, tolerance):
        n, rng = run.dimension, np.random.default_rng(6)
        normalised = rng.uniform(run.problem.workspace_lower, run.problem.workspace_upper, (400, n))
        found = self.answers(header, run.data.to_data(normalised))
        error = np.linalg.norm(found[:, :n] / run.data.velocity_scale - run.f(normalised), axis=1).max()
        self.assertLess(error, tolerance)
        V, B = run.V(normalised), run.B(normalised)
        np.testing.assert_allclose(found[:, n], V, rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(found[:, n + 1], B, rtol=1e-11, atol=1e-12)
        np.testing.assert_array_equal(found[:, n + 2] == 1, B <= 0)

    def export(self, run, out, *words):
        code, text, err = self.call("export", run, "--format", "header", "--out", self.path(out), *words)
        self.assertEqual((code, err), (0, ""), text)
        self.assertIn("C++ header", text)

    def test_same_values_as_the_run_file(self):
        for name, changes in (
            ("default", {}),
            ("paper", {"profile": '"paper"'}),
            ("mixed", {"networks.f.activation": '"sine"', "networks.V.activation": '"softplus"', "networks.B.activation": '"silu"'}),
        ):
            with self.subTest(changes=changes):
                path = self.trained(changes=changes)
                self.export(path, f"{name}.h")
                self.assert_same_values(f"{name}.h", Run(path), 1e-4)
                self.export(path, f"{name}_double.h", "--precision", "double")
                self.assert_same_values(f"{name}_double.h", Run(path), 1e-12)

    def test_it_lies_beside_the_run_by_default(self):
        code, _, err = self.call("export", self.trained())
        self.assertEqual((code, err), (0, ""))
        self.assertEqual(sorted(os.listdir(self.folder)), ["run.h", "run.h5"])


class PlotTest(ProgramTest):
    def test_figures_are_pictures(self):
        code, _, err = self.call("plot", self.trained(), "--out", self.path("figures"))
        self.assertEqual((code, err), (0, ""))
        figures = os.listdir(self.path("figures"))
        self.assertGreaterEqual(len(figures), 2)
        for name in figures:
            with open(os.path.join(self.path("figures"), name), "rb") as file:
                head = file.read()
            self.assertTrue(name.endswith(".png"), name)
            self.assertTrue(head.startswith(b"\x89PNG\r\n\x1a\n") and len(head) > 5000, name)

    def test_default_folder_lies_beside_the_run(self):
        code, _, err = self.call("plot", self.trained())
        self.assertEqual((code, err), (0, ""))
        self.assertEqual(sorted(os.listdir(self.folder)), ["run-figures", "run.h5"])


if __name__ == "__main__":
    command_line.main()
