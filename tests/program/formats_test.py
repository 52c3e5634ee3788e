#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Every export format against the run file's own networks: the C++ header, ONNX, pt2 and TorchScript agree with Python.

What this Python cannot read is skipped with a message; the whole needs torch 2.6 or newer, onnxruntime, h5py and a compiler.
"""

import json
import os
import subprocess
import unittest
import warnings

import command_line
import frame_test
import numpy as np
from command_line import PROJECT, ProgramTest, torch_export
from s2nnds.run import Run

HELIX = os.path.join(PROJECT, "experiments/configs/handwriting/Helix.toml")  # three dimensions

# Of the largest velocity (normalised), V and B, or of 1 where they are smaller.
TOLERANCE = 1e-6

DRIVER = """
#include "{folder}/policy_{precision}.h"
#include <cstdio>
namespace policy = policy_policy_{precision};
int main(int count, char**) {{
  if (count > 1) {{
    std::printf("%s\\n%s\\n%s\\n%.17g %.17g", policy::unit, policy::frame_name, policy::unsafe_set, policy::position_scale,
                policy::velocity_scale);
    for (double value : policy::goal) std::printf(" %.17g", value);
    for (double value : policy::workspace) std::printf(" %.17g", value);
    return 0;
  }}
  double x[policy::dimension], v[policy::dimension];
  for (;;) {{
    for (double& value : x) {{
      if (std::scanf("%lf", &value) != 1) return 0;
    }}
    policy::velocity(x, v);
    for (double value : v) std::printf("%.17g ", value);
    std::printf("%.17g %.17g %d\\n", policy::lyapunov(x), policy::barrier(x), int(policy::safe(x)));
  }}
}}
"""


# What every format says of the positions that it takes.
ABOUT = ("unit", "frame_name", "unsafe_set", "goal", "workspace", "position_scale", "velocity_scale")


class Missing(Exception):
    """What this machine lacks to use a format."""


class Header:
    def __init__(self, export, folder, precision):
        export("header", f"policy_{precision}.h", "--precision", precision)
        self.driver = os.path.join(folder, f"driver_{precision}")
        with open(self.driver + ".cpp", "w", encoding="utf-8") as file:
            file.write(DRIVER.format(folder=folder, precision=precision))
        flags = ("-std=c++17", "-O2", "-march=native")
        subprocess.run(["g++", *flags, self.driver + ".cpp", "-o", self.driver], check=True)

    @property
    def about(self):
        done = subprocess.run([self.driver, "about"], capture_output=True, text=True, check=True)
        unit, frame, unsafe, numbers = done.stdout.splitlines()
        scale, speed, *rest = [float(word) for word in numbers.split()]
        n = len(rest) // 3
        return {"unit": unit, "frame_name": frame, "unsafe_set": unsafe, "position_scale": scale, "velocity_scale": speed,
                "goal": rest[:n], "workspace": rest[n:]}  # fmt: skip

    def __call__(self, x):
        n = x.shape[1]
        text = "\n".join(" ".join(f"{value:.17g}" for value in point) for point in x)
        done = subprocess.run([self.driver], input=text, capture_output=True, text=True, check=True)
        rows = np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])
        return rows[:, :n], rows[:, n], rows[:, n + 1], rows[:, n + 2] == 1.0


class Onnx:
    def __init__(self, export, folder):
        try:
            import onnxruntime
        except ImportError as error:
            raise Missing(f"no ONNX runtime: {error}") from None
        path = export("onnx", "policy.onnx")
        self.session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
        self.about = dict(self.session.get_modelmeta().custom_metadata_map)
        for name in ("goal", "workspace", "position_scale", "velocity_scale"):
            numbers = [float(word) for word in self.about[name].split(",")]
            self.about[name] = numbers[0] if name.endswith("scale") else numbers

    def __call__(self, x):
        return tuple(self.session.run(["velocity", "lyapunov", "barrier", "safe"], {"position": x}))


class Pt2:
    def __init__(self, export, folder, dtype):
        if torch_export() is not None:
            raise Missing(torch_export())
        import torch

        self.torch, self.dtype = torch, dtype
        about = {"policy.json": ""}
        self.module = torch.export.load(export("pt2", "policy.pt2"), extra_files=about).module()
        self.about = json.loads(about["policy.json"])

    def __call__(self, x):
        values = self.module(self.torch.as_tensor(x.astype(self.dtype)))
        return tuple(values[name].numpy() for name in ("velocity", "lyapunov", "barrier", "safe"))


class TorchScript:
    def __init__(self, export, folder, dtype):
        try:
            import torch
        except ImportError as error:
            raise Missing(f"no torch: {error}") from None
        self.torch, self.dtype = torch, dtype
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that PyTorch deprecates it
            policy = torch.jit.load(export("torchscript", "policy.pt"))
        self.policy = policy.double() if dtype == "float64" else policy
        self.about = {name: getattr(policy, name) for name in ABOUT}

    def __call__(self, x):
        p, t = self.policy, self.torch.as_tensor(x.astype(self.dtype))
        return tuple(values.numpy() for values in (p(t), p.lyapunov(t), p.barrier(t), p.safe(t)))


class InPython:
    """Run.policy(): what an export answers, without one."""

    def __init__(self, run):
        try:
            import torch
        except ImportError as error:
            raise Missing(f"no torch: {error}") from None
        self.torch, self.policy = torch, Run(run).policy()
        self.about = {name: getattr(self.policy, name) for name in ABOUT}

    def __call__(self, x):
        p, t = self.policy, self.torch.as_tensor(x)
        return tuple(values.detach().numpy() for values in (p(t), p.lyapunov(t), p.barrier(t), p.safe(t)))


FORMATS = {
    "header, float": lambda export, folder: Header(export, folder, "float"),
    "header, double": lambda export, folder: Header(export, folder, "double"),
    "onnx": Onnx,
    "pt2, float64 in": lambda export, folder: Pt2(export, folder, "float64"),
    "pt2, float32 in": lambda export, folder: Pt2(export, folder, "float32"),
    "torchscript, float32": lambda export, folder: TorchScript(export, folder, "float32"),
    "torchscript, float64": lambda export, folder: TorchScript(export, folder, "float64"),
}


class FormatsTest(ProgramTest):
    def exporter(self, run):
        done = set()

        def export(kind, name, *words):
            if name in done:  # pt2 takes seconds
                return self.path(name)
            done.add(name)
            code, out, err = self.call("export", run, "--format", kind, "--out", self.path(name), *words)
            self.assertEqual((code, err), (0, ""), out)
            return self.path(name)

        return export

    def compare(self, run, policy, x):
        """The largest differences of velocity (normalised), V and B, over what they are allowed to be relative to."""
        found = policy(x)
        normalised = run.data.to_normalized(x)
        expected = run.data.velocity_scale * run.f(normalised), run.V(normalised), run.B(normalised)
        errors = []
        for values, exact, unit in zip(found, expected, (run.data.velocity_scale, 1.0, 1.0)):
            self.assertEqual(values.shape, exact.shape)
            errors.append(np.abs(values - exact).max() / max(unit, np.abs(exact).max()))
        inside = np.all((normalised >= run.problem.workspace_lower) & (normalised <= run.problem.workspace_upper), axis=1)
        certain = np.abs(expected[2]) > TOLERANCE * max(1.0, np.abs(expected[2]).max())
        self.assertEqual(found[3].shape, (len(x),))
        safe = (expected[2] <= 0.0) & inside
        self.assertFalse(np.any(found[3] & ~safe & certain))
        surely = safe & (expected[2] < -1e-3 * max(1.0, np.abs(expected[2]).max()))  # beyond the bound on rounding
        np.testing.assert_array_equal(found[3][surely], True)
        return errors

    @staticmethod
    def extended_barrier(run, x):
        """B at positions [N, n] in numpy's long double, whose rounding is nothing beside that of the formats."""
        extended = np.longdouble
        a = (x.astype(extended) - run.data.goal.astype(extended)) / extended(run.data.position_scale)
        for weight, bias, activation in run.B.layers:
            a = a @ weight.astype(extended).T + bias.astype(extended)
            a = np.tanh(a) if activation == "tanh" else a
        return a[:, 0]

    def test_safe_is_never_true_where_the_exact_barrier_is_positive(self):
        path = self.trained()
        run, rng = Run(path), np.random.default_rng(5)
        corners = run.data.to_data(run.problem.workspace_lower), run.data.to_data(run.problem.workspace_upper)
        inside, outside = (rng.uniform(*corners, (20000, 2)) for _ in range(2))
        chosen = (self.extended_barrier(run, inside) <= 0) & (self.extended_barrier(run, outside) > 0)
        inside, outside = inside[chosen], outside[chosen]
        for _ in range(60):
            middle = 0.5 * (inside + outside)
            above = self.extended_barrier(run, middle) > 0
            inside[~above], outside[above] = middle[~above], middle[above]
        x = np.concatenate([inside, outside])
        exact = self.extended_barrier(run, x)
        self.assertGreater(np.sum(exact > 0), 100)
        self.assertFalse(np.any(run.safe(x) & (exact > 0)))
        export = self.exporter(path)
        for name, reader in FORMATS.items():
            with self.subTest(format=name):
                try:
                    policy = reader(export, self.folder)
                except Missing as missing:
                    self.skipTest(f"{name}: {missing}")
                # Positions that the format takes in float32 are those that it sees.
                seen = x.astype(np.float32).astype(float) if getattr(policy, "dtype", "") == "float32" else x
                exact = self.extended_barrier(run, seen)
                _, _, barrier, safe = policy(seen)
                self.assertFalse(np.any(safe & (exact > 0)))
                bound = run.certificate[f"barrier_float{64 if name.startswith(('header', 'pt2')) else 32}_error"]
                largest = float(np.abs(barrier - exact).max())
                print(f"  {name:22} |B - exact B| <= {largest:.1e}, bound {bound:.1e}")
                self.assertLess(largest, bound)
                if name != "torchscript, float64":  # its weights are rounded to float32 or happen not to be
                    self.assertLess(bound, 1e4 * largest)

    def assert_formats_agree(self, title, path, formats=None):
        run, rng = Run(path), np.random.default_rng(3)
        # Positions that float32 holds, some of them outside of the workspace.
        points = rng.uniform(1.2 * run.problem.workspace_lower, 1.2 * run.problem.workspace_upper, (1008, run.dimension))
        points = run.data.to_data(points).astype(np.float32).astype(float)
        export = self.exporter(path)
        for name, reader in (formats or FORMATS).items():
            with self.subTest(run=title, format=name):
                try:
                    policy = reader(export, self.folder)
                except Missing as missing:
                    self.skipTest(f"{name}: {missing}")
                # One point, seven, a thousand: N is free.
                errors = np.max([self.compare(run, policy, part) for part in np.split(points, [1, 8])], axis=0)
                print(f"  {title:28} {name:22} f {errors[0]:.1e}  V {errors[1]:.1e}  B {errors[2]:.1e}")
                self.assertLess(errors.max(), TOLERANCE)

    def test_tanh_and_the_heads_of_the_robust_profile(self):
        self.assert_formats_agree("2-D, tanh", self.trained())

    def test_other_activations(self):
        for f, V, B in (("sine", "softplus", "silu"), ("elu", "tanh", "elu")):
            changes = {f"networks.{key}.activation": f'"{kind}"' for key, kind in zip("fVB", (f, V, B))}
            self.assert_formats_agree(f"2-D, {f} {V} {B}", self.trained(changes=changes))

    def test_plain_heads_of_the_papers_profile(self):
        self.assert_formats_agree("2-D, paper", self.trained(changes={"profile": '"paper"'}))

    def test_three_dimensions(self):
        for f in ("tanh", "silu"):
            changes = {"networks.f.activation": f'"{f}"'}
            self.assert_formats_agree(f"3-D, {f}", self.trained(changes=changes, config=HELIX))

    def test_a_projected_motion(self):
        projected = {"networks.f.form": '"projected"', "networks.f.decay": 2.0}
        able = {name: reader for name, reader in FORMATS.items() if name.startswith(("header", "onnx"))}
        self.assertGreaterEqual(len(able), 3)
        for config, title in ((command_line.SINE, "2-D, projected"), (HELIX, "3-D, projected")):
            path = self.trained(changes=projected, config=config)
            run, rng = Run(path), np.random.default_rng(4)
            z = rng.uniform(run.problem.workspace_lower, run.problem.workspace_upper, (500, run.dimension))
            changed = np.linalg.norm(run.f(z) - run.f.network(z), axis=1)
            self.assertGreater(np.mean(changed > 1e-3), 0.05)  # so that it matters
            self.assertGreater(np.mean(changed == 0.0), 0.01)
            self.assert_formats_agree(title, path, able)
            for kind in ("pt2", "torchscript"):
                self.assert_refused(self.call("export", path, "--format", kind), kind, "projected", "header")

    def test_wide_networks(self):
        changes = {"networks.f.hidden": "[64, 64, 64]", "networks.V.hidden": "[64, 64]", "networks.B.hidden": "[64, 64]"}
        self.assert_formats_agree("2-D, 64 wide", self.trained(changes=changes))

    def test_certified_networks(self):
        path = self.certified()
        code, _, err = self.call("verify", path, "--method", "proof")
        self.assertEqual(code, 0, err)
        self.assertEqual(Run(path).guarantee, "invariant")
        self.assert_formats_agree("2-D, certified", path)

    @unittest.skipIf(torch_export(), torch_export())
    def test_pt2_carries_what_is_guaranteed(self):
        path = self.certified()
        code, _, err = self.call("verify", path, "--method", "sampled")
        self.assertEqual(code, 0, err)
        run, about = Run(path), Pt2(self.exporter(path), self.folder, "float64").about
        self.assertEqual((about["guarantee"], run.guarantee), ("sampled", "sampled"))
        self.assertEqual(about["weight_hash"], run.certificate["weight_hash"])
        self.assertEqual(about["statement"], run.certificate["statement"])
        self.assertEqual((about["dimension"], about["name"], about["unit"]), (2, "Sine", "mm"))
        self.assertEqual(about["position_scale"], run.data.position_scale)
        self.assertEqual(about["velocity_scale"], run.data.velocity_scale)
        self.assertEqual(about["goal"], run.data.goal.tolist())
        corners = [run.data.to_data(run.problem.workspace_lower), run.data.to_data(run.problem.workspace_upper)]
        np.testing.assert_allclose(about["workspace"], np.concatenate(corners), rtol=1e-12)
        keys = {"disturbance_margin", "convergence_radius", "float32_error"}
        self.assertTrue(keys <= about.keys(), about)

    @unittest.skipIf(torch_export(), torch_export())
    def test_pt2_takes_no_points_and_not_a_number(self):
        import torch

        policy = Pt2(self.exporter(self.trained()), self.folder, "float64")
        self.assertEqual([len(values) for values in policy(np.zeros((0, 2)))], [0, 0, 0, 0])
        velocity, lyapunov, barrier, safe = policy(np.array([[np.nan, 0.0], [0.0, 0.0]]))
        self.assertTrue(np.isnan([*velocity[0], lyapunov[0], barrier[0]]).all())
        self.assertFalse(safe[0])
        np.testing.assert_allclose(velocity[1], 0.0, atol=1e-12)
        with self.assertRaises(Exception):
            policy.module(torch.zeros(4, 3, dtype=torch.float64))

    def test_goals_far_from_the_origin(self):
        for kind in (frame_test.MILLIMETRES, frame_test.METRES):
            name = f"far_{kind['unit']}"
            frame_test.write(self.folder, kind, name=name)
            path = self.trained(config=self.path(name + ".toml"))
            title = f"2-D, far goal, {kind['unit']}"
            self.assert_formats_agree(title, path)
            run, export = Run(path), self.exporter(path)
            x = frame_test.place(kind, -0.5, 0.2) + np.zeros((1, 2))
            for name, reader in (*FORMATS.items(), ("Python", lambda export, folder, path=path: InPython(path))):
                with self.subTest(run=title, format=name):
                    try:
                        policy = reader(export, self.folder)
                    except Missing as missing:
                        self.skipTest(f"{name}: {missing}")
                    self.assert_says_where_it_is(policy.about, kind, run)
                    self.assertLess(max(self.compare(run, policy, x.astype(np.float32).astype(float))), TOLERANCE)

    def assert_says_where_it_is(self, about, kind, run):
        """Unit, frame, goal, workspace, scales and obstacle, as the user wrote them or would."""
        self.assertEqual((about["unit"], about["frame_name"]), (kind["unit"], "base_link"))
        ball = ", ".join(f"{c:g}" for c in frame_test.place(kind, -0.5, 0.8))
        self.assertEqual(about["unsafe_set"], f"ball centre ({ball}) radius {0.1 * kind['size']:g}")
        size = kind["size"]
        np.testing.assert_allclose(about["goal"], kind["goal"], atol=1e-6 * size)
        corners = frame_test.place(kind, -1.25, -1.25) + frame_test.place(kind, 1.25, 1.25)
        np.testing.assert_allclose(about["workspace"], corners, atol=1e-6 * size)
        np.testing.assert_allclose(about["position_scale"], size, rtol=1e-6)
        self.assertEqual(about["velocity_scale"], run.data.velocity_scale)

    def test_onnx_takes_float64_alone(self):
        try:
            policy = Onnx(self.exporter(self.trained()), self.folder)
        except Missing as missing:
            self.skipTest(str(missing))
        with self.assertRaisesRegex(Exception, r"tensor\(float\).*tensor\(double\)"):
            policy.session.run(None, {"position": np.zeros((1, 2), dtype=np.float32)})


if __name__ == "__main__":
    command_line.main()
