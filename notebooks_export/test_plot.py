#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of the run reader and the figures on synthetic run files.

/usr/bin/python3 notebooks_export/test_plot.py
"""

import contextlib
import hashlib
import io
import math
import os
import shutil
import struct
import sys
import tempfile
import unittest

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "python"))

import readme_picture
from s2nnds import plot_run
from s2nnds.isosurface import isosurface
from s2nnds.run import ACTIVATIONS, Network, Run, RunError, weight_hash


def random_network(rng, n, outputs, activation="tanh", head="plain", quadratic=0.0, bias=True):
    sizes = [n, 6, 5, outputs]
    layers = []
    for k, (inputs, size) in enumerate(zip(sizes, sizes[1:])):
        layers.append(
            (
                rng.normal(size=(size, inputs)),
                rng.normal(size=size) if bias else np.zeros(size),
                activation if k < 2 else "identity",
            )
        )
    return Network(layers, head, quadratic)


def write_network(group, network, bias=True):
    group.attrs["head"] = network.head
    group.attrs["quadratic"] = network.quadratic
    group.attrs["layers"] = len(network.layers)
    for k, (weight, offset, activation) in enumerate(network.layers):
        group[f"weight_{k}"] = weight
        if bias:
            group[f"bias_{k}"] = offset
        group.attrs[f"activation_{k}"] = activation


def demonstration(n, k):
    """A curved motion that ends at the goal: normalised positions and velocities at 60 times in seconds."""
    time = np.linspace(0.0, 3.0, 60)
    s = time / 3.0
    progress = 10 * s**3 - 15 * s**4 + 6 * s**5
    left = 1.0 - progress
    position = np.column_stack(
        [
            -0.9 * left,
            (0.3 + 0.03 * k) * left + 0.45 * np.sin(2.5 * left) * left,
            *(0.6 * left * np.cos(2 * left + j) for j in range(n - 2)),
        ]
    )
    velocity = np.gradient(position, time, axis=0)
    return time, position, velocity / np.abs(velocity).max()


def with_digest(path):
    """Ends the file as the program does."""
    with open(path, "rb") as file:
        digest = hashlib.sha256(file.read()).hexdigest()
    with open(path, "a", encoding="ascii") as file:
        file.write(f"\ns2nnds-sha256 {digest}\n")


def synthetic_run(path, n=2, rounds=9, grid=True, open_boxes=0, guarantee="invariant", count=None):
    """A run file as the program writes it. The motion is linear; the grid's sets are given, not learned."""
    rng = np.random.default_rng(7)
    matrix = -np.eye(n)
    matrix[0, 1], matrix[1, 0] = -0.8, 0.8
    f = Network([(matrix, np.zeros(n), "identity")], "zero_at_origin")
    V = random_network(rng, n, 4, head="squared_norm", quadratic=0.05)
    B = random_network(rng, n, 1)
    centre = np.array([-0.35, -0.45, 0.25, 0.0, 0.0, 0.0, 0.0])[:n]
    with h5py.File(path, "w") as file:
        file.attrs.update(
            schema_version=5,
            program_version="0.1.0",
            library_versions="none",
            seed=3,
            created="2020-01-01T00:00:00Z",
            name=f"Synthetic {n}-D",
        )
        config = file.create_group("config")
        config["text"], config["resolved"] = "name = 'synthetic'\n", "name = 'synthetic'\nseed = 3\n"
        config.create_group("values").attrs.update({"training.rounds": rounds, "problem.workspace": 1.25})
        data = file.create_group("data")
        data.attrs.update(
            position_scale=46.25, velocity_scale=120.0, normalization="max_abs", unit="mm", dimension=n, frame_name="base"
        )
        data["train"], data["test"] = [0, 1, 2, 3, 4], [5, 6]
        goals = data["goals"] = np.arange(100.0, 100.0 + 7 * n).reshape(7, n)
        data["goal"] = goals[()].mean(axis=0)
        for k in range(7):
            group = data.create_group(f"demonstrations/{k}")
            time, position, velocity = demonstration(n, k)
            group["time"], group["position"] = time + 5.0, goals[k] + 46.25 * position
            group["velocity"] = 120.0 * velocity
        problem = file.create_group("problem")
        problem.attrs.update(frame="data", unsafe="ball", initial="box", containment=0.97, level_band=0.02)
        problem["workspace_lower"], problem["workspace_upper"] = np.full(n, -1.25), np.full(n, 1.25)
        history = file.create_group("history")
        history["round"] = np.arange(1, rounds + 1)
        history["loss"] = 0.4 * 0.7 ** np.arange(rounds)
        history["mse"] = history["imitation"] = 0.05 * 0.9 ** np.arange(rounds) + 0.01
        history["lyapunov"] = np.zeros(rounds)
        history["safe_share"] = np.linspace(0.5, 0.9, rounds)
        history["stage"] = np.arange(rounds) * 3 // rounds
        counts = np.maximum(0, (9000 * 0.25 ** np.arange(rounds)).astype(int) - 1)
        for k, name in enumerate(
            ("lyapunov_positive", "lyapunov_decrease", "initial", "unsafe", "containment", "barrier_decrease")
        ):
            history[f"count_{name}"] = counts // (k + 1) if k else 0 * counts
        history["seconds"] = np.linspace(1.0, 1.6, rounds)
        for name, network in (("f", f), ("V", V), ("B", B)):
            write_network(file.create_group(f"networks/{name}"), network)
        certificate = file.create_group("certificate")
        digest = weight_hash(f, V, B)
        scope = f"""
            weights = "{digest}"
            frame = {{ goal = {data["goal"][()].tolist()}, position_scale = 46.25, velocity_scale = 120.0 }}
            problem.workspace_lower = {[-1.25] * n}
            problem.workspace_upper = {[1.25] * n}
            problem.level_band = 0.02
        """
        certificate.attrs.update(
            guarantee=guarantee,
            method="proof",
            weight_hash=digest,
            scope=scope,
            disturbance_margin=0.01,
            convergence_radius=0.02,
            statement="synthetic",
        )
        condition = certificate.create_group("conditions/0")
        condition.attrs.update(
            condition="lyapunov_decrease",
            method="proof",
            verdict="undecided",
            boxes=1000,
            open_boxes=open_boxes,
        )
        if open_boxes:
            low = rng.uniform(-0.2, 0.9, size=(open_boxes, n))
            certificate["open_boxes/lyapunov_decrease"] = np.hstack(
                [low, low + rng.uniform(1e-4, 0.04, low.shape)]
            )
        file.create_group("evaluation").attrs.update(
            mse_train=0.0123, mse_test=0.0215, safe_area=4.9, true_safe_area=5.3, dtw=math.nan
        )
        file.create_group("timing").attrs.update(train=12.5, proof=0.8)
        starts = [(demonstration(n, k)[1][0], "test" if k > 4 else "train") for k in range(7)]
        starts += [(start, "grid") for start in rng.uniform(-1.1, 1.1, size=(12, n))]
        time = np.linspace(0.0, 6.0, 121)
        for k, (start, kind) in enumerate(starts):
            group = file.create_group(f"rollouts/{k}")
            turn = np.exp(-time)[:, None]
            cos, sin = np.cos(0.8 * time), np.sin(0.8 * time)
            position = np.repeat(start[None], len(time), axis=0)
            position[:, 0], position[:, 1] = cos * start[0] - sin * start[1], sin * start[0] + cos * start[1]
            group["time"], group["position"] = time, turn * position
            failed = kind == "grid" and k % 5 == 0
            if failed:
                del group["time"], group["position"]
                group["time"], group["position"] = time[:12], (turn * position)[:12]
            group.attrs.update(stop="entered_unsafe" if failed else "reached_goal", start_kind=kind)
        if grid and n <= 3:
            size = count or (101 if n == 2 else 31)
            axes = [np.linspace(-1.25, 1.25, size) for _ in range(n)]
            points = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
            distance = np.linalg.norm(points - centre, axis=-1)
            start = np.array([-0.9, 0.6, 0.6 * np.cos(2.0)])[:n]
            group = file.create_group("grid")
            for k, axis in enumerate(axes):
                group[f"axis_{k}"] = axis
            group["unsafe"] = distance - 0.22
            group["initial"] = np.max(np.abs(points - start), axis=-1) - 0.1
            edge = np.linalg.norm(points, ord=6, axis=-1) - 1.15
            group["B"] = np.maximum(edge, 0.27 - distance - 0.1 * (points[..., 0] - centre[0]))
            group["V"] = V(points.reshape(-1, n)).reshape(points.shape[:-1])
            group["velocity"] = points @ matrix.T
    with_digest(path)


def value_by_loops(network, x):
    """y(x) of one point, number by number."""
    scalar = {
        "identity": lambda z: z,
        "tanh": math.tanh,
        "elu": lambda z: z if z > 0 else math.exp(z) - 1,
        "softplus": lambda z: math.log(1 + math.exp(z)),
        "silu": lambda z: z / (1 + math.exp(-z)),
        "sine": math.sin,
    }

    def layers(values):
        for weight, bias, activation in network.layers:
            values = [
                scalar[activation](sum(weight[o][i] * values[i] for i in range(len(values))) + bias[o])
                for o in range(len(weight))
            ]
        return values

    out, zero = layers(list(x)), layers([0.0] * len(x))
    if network.head == "plain":
        return out
    out = [a - b for a, b in zip(out, zero)]
    if network.head == "zero_at_origin":
        return out
    return [sum(a * a for a in out) + network.quadratic * sum(a * a for a in x)]


class TemporaryFolder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)


class NetworkTest(unittest.TestCase):
    def test_value_is_that_of_a_plain_loop(self):
        rng = np.random.default_rng(1)
        for n in (2, 3, 5):
            for activation in ACTIVATIONS:
                for head in ("plain", "zero_at_origin", "squared_norm"):
                    network = random_network(rng, n, 3, activation, head, quadratic=0.3)
                    x = rng.normal(size=(4, n))
                    want = np.array([value_by_loops(network, point) for point in x])
                    got = np.reshape(network(x), want.shape)
                    np.testing.assert_allclose(got, want, rtol=1e-12, atol=1e-13)
                    np.testing.assert_allclose(np.ravel(network(x[0])), want[0], rtol=1e-12, atol=1e-13)

    def test_jacobian_is_the_limit_of_differences(self):
        rng = np.random.default_rng(2)
        for activation in ACTIVATIONS:
            for head, outputs in (("plain", 3), ("zero_at_origin", 2), ("squared_norm", 4), ("plain", 1)):
                network = random_network(rng, 3, outputs, activation, head, quadratic=0.2)
                x, h = rng.normal(size=(5, 3)), 1e-6
                jacobian = network.jacobian(x)
                self.assertEqual(jacobian.shape, (5, network.output_dimension, 3))
                for k in range(3):
                    step = h * np.eye(3)[k]
                    difference = (network(x + step) - network(x - step)) / (2 * h)
                    np.testing.assert_allclose(
                        jacobian[:, :, k], difference.reshape(5, -1), rtol=1e-6, atol=1e-7
                    )

    def test_heads_at_the_goal(self):
        rng = np.random.default_rng(3)
        V = random_network(rng, 2, 4, head="squared_norm", quadratic=0.05)
        self.assertEqual(V(np.zeros(2)), 0.0)
        np.testing.assert_array_equal(V.gradient(np.zeros(2)), np.zeros(2))
        f = random_network(rng, 2, 2, head="zero_at_origin")
        np.testing.assert_array_equal(f(np.zeros(2)), np.zeros(2))

    def test_large_arguments_do_not_overflow(self):
        for activation in ACTIVATIONS:
            value, slope = ACTIVATIONS[activation]
            with np.errstate(over="raise", invalid="raise"):
                z = np.array([-800.0, 800.0])
                self.assertTrue(np.isfinite(value(z)).all() and np.isfinite(slope(z)).all(), activation)

    def test_wrong_shapes_are_named(self):
        network = random_network(np.random.default_rng(4), 2, 2)
        with self.assertRaisesRegex(ValueError, r"expected \[N, 2\]"):
            network(np.zeros((5, 3)))
        with self.assertRaisesRegex(ValueError, "expected 1"):
            network.gradient(np.zeros(2))


class IsosurfaceTest(unittest.TestCase):
    def test_sphere(self):
        axes = [np.linspace(-1, 1, size) for size in (33, 37, 41)]
        x, y, z = np.meshgrid(*axes, indexing="ij")
        triangles = isosurface(axes, np.sqrt(x**2 + y**2 + z**2) - 0.7)
        radii = np.linalg.norm(triangles, axis=-1)
        self.assertLess(np.abs(radii - 0.7).max(), 2e-3)
        cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        area = 0.5 * np.linalg.norm(cross, axis=1).sum()
        self.assertAlmostEqual(area, 4 * np.pi * 0.49, delta=0.02)
        volume = np.abs(np.einsum("ti,ti->t", triangles[:, 0], cross)).sum() / 6
        self.assertAlmostEqual(volume, 4 / 3 * np.pi * 0.343, delta=0.02)

    def test_nothing_to_draw(self):
        axes = [np.linspace(0, 1, 5)] * 3
        self.assertEqual(len(isosurface(axes, np.ones((5, 5, 5)))), 0)
        self.assertEqual(len(isosurface(axes, -np.ones((5, 5, 5)))), 0)
        self.assertEqual(len(isosurface(axes, np.full((5, 5, 5), np.nan))), 0)


class ReaderTest(TemporaryFolder):
    def test_everything_comes_back(self):
        synthetic_run(self.path("run.h5"), n=2, open_boxes=5)
        run = Run(self.path("run.h5"))
        self.assertEqual(
            (run.name, run.seed, run.guarantee, run.dimension), ("Synthetic 2-D", 3, "invariant", 2)
        )
        self.assertEqual(run.config["problem.workspace"], 1.25)
        self.assertIn("seed = 3", run.config_resolved)
        self.assertEqual((run.data.unit, run.data.position_scale, run.data.test), ("mm", 46.25, [5, 6]))
        self.assertEqual((run.data.frame_name, run.problem.frame), ("base", "data"))
        self.assertEqual(len(run.data.demonstrations), 7)
        time, position, velocity = demonstration(2, 4)
        as_read, normalized = run.data.demonstrations[4], run.data.normalized[4]
        np.testing.assert_allclose(as_read.position, run.data.goals[4] + 46.25 * position)
        np.testing.assert_allclose(normalized.position, position, atol=1e-14)
        np.testing.assert_allclose(normalized.velocity, velocity)
        np.testing.assert_allclose(normalized.time, time * 120.0 / 46.25, atol=1e-14)
        self.assertEqual((run.problem.containment, run.problem.level_band), (0.97, 0.02))
        self.assertEqual(run.history["mse"].shape, (9,))
        self.assertEqual(run.certificate["conditions"][0]["condition"], "lyapunov_decrease")
        self.assertEqual(run.certificate["conditions"][0]["open_boxes"], 5)
        self.assertEqual(run.open_boxes["lyapunov_decrease"].shape, (5, 4))
        self.assertEqual(run.evaluation["mse_test"], 0.0215)
        self.assertEqual(
            [rollout.start_kind for rollout in run.rollouts[4:8]], ["train", "test", "test", "grid"]
        )
        self.assertEqual(len(run.rollouts), 19)  # in numerical order, 10 after 9
        x = np.array([0.5, -0.25])
        np.testing.assert_allclose(run.f(x), [-0.5 + 0.2, 0.4 + 0.25])
        i, j = 20, 70
        at = [run.grid.axes[0][i], run.grid.axes[1][j]]
        self.assertAlmostEqual(run.grid.V[i, j], run.V(at), places=12)
        np.testing.assert_allclose(run.grid.velocity[i, j], run.f(at), atol=1e-12)

    def test_a_certificate_of_another_run_is_refused(self):
        path = os.path.join(self.folder, "edited.h5")
        edits = {
            "networks/f/weight_0": lambda item: item.__setitem__((0, 0), 5.0),
            "problem/workspace_upper": lambda item: item.__setitem__(0, 2.0),
            "data": lambda item: item.attrs.__setitem__("position_scale", 92.5),
            "certificate": lambda item: item.attrs.__setitem__("scope", ""),
        }
        for name, edit in edits.items():
            synthetic_run(path)
            Run(path)
            with h5py.File(path, "r+") as file:
                edit(file[name])
            with_digest(path)
            with self.assertRaisesRegex(RunError, "its certificate speaks of", msg=name):
                Run(path)

    def test_a_certified_run_that_was_written_to_is_refused(self):
        path = self.path("edited.h5")
        edits = {
            "certificate": lambda item: item.attrs.__setitem__("disturbance_margin", 0.5),
            "problem": lambda item: item.attrs.__setitem__("unsafe", "none"),
            "config": lambda item: item.attrs.__setitem__("note", "other"),
            "certificate/conditions/0": lambda item: item.attrs.__setitem__("verdict", "proved"),
        }
        for name, edit in edits.items():
            synthetic_run(path)
            with h5py.File(path, "r+") as file:
                edit(file[name])
            with self.assertRaisesRegex(RunError, "something else than the program has written to", msg=name):
                Run(path)
        synthetic_run(path, guarantee="none")
        with h5py.File(path, "r+") as file:
            file["certificate"].attrs["disturbance_margin"] = 0.5
        self.assertEqual(Run(path).guarantee, "none")

    def test_in_the_datas_unit_everything_shares_one_frame(self):
        synthetic_run(self.path("run.h5"), open_boxes=5)
        run = Run(self.path("run.h5"))
        shown, goal = run.in_data_unit(), run.data.goal
        np.testing.assert_allclose(goal, run.data.goals.mean(axis=0))
        np.testing.assert_allclose(run.data.to_normalized(run.data.to_data([0.5, -1.0])), [0.5, -1.0])
        np.testing.assert_allclose(shown.problem.workspace_upper, goal + 1.25 * 46.25)
        np.testing.assert_allclose(shown.rollouts[2].position, goal + 46.25 * run.rollouts[2].position)
        np.testing.assert_allclose(shown.rollouts[2].time, run.rollouts[2].time * 46.25 / 120.0)
        np.testing.assert_allclose(shown.grid.axes[1], goal[1] + 46.25 * run.grid.axes[1])
        np.testing.assert_allclose(shown.grid.velocity, 120.0 * run.grid.velocity)
        boxes = shown.open_boxes["lyapunov_decrease"]
        np.testing.assert_allclose(boxes, np.tile(goal, 2) + 46.25 * run.open_boxes["lyapunov_decrease"])
        for moved, normalized in zip(shown.data.demonstrations, run.data.normalized):
            np.testing.assert_allclose(moved.position, goal + 46.25 * normalized.position)
        for again, normalized in zip(shown.data.normalized, run.data.normalized):
            np.testing.assert_allclose(again.position, normalized.position, atol=1e-12)
        np.testing.assert_array_equal(run.problem.workspace_upper, [1.25, 1.25])  # the run itself stays

    def test_the_policy_speaks_the_datas_frame(self):
        synthetic_run(self.path("run.h5"))
        run = Run(self.path("run.h5"))
        z = np.array([[0.5, -0.25], [0.0, 0.0], [1.3, 0.0]])
        x = run.data.to_data(z)
        np.testing.assert_allclose(run.velocity(x), 120.0 * run.f(z), atol=1e-12)
        np.testing.assert_allclose(run.lyapunov(x), run.V(z), atol=1e-12)
        np.testing.assert_allclose(run.barrier(x), run.B(z), atol=1e-12)
        np.testing.assert_array_equal(run.safe(x), (run.B(z) <= 0.0) & [True, True, False])
        self.assertEqual(run.velocity(x[0]).shape, (2,))
        self.assertIsInstance(bool(run.safe(x[0])), bool)

    def test_a_missing_bias_is_zero(self):
        synthetic_run(self.path("run.h5"), guarantee="none")
        V = random_network(np.random.default_rng(5), 2, 1, "elu", bias=False)
        with h5py.File(self.path("run.h5"), "a") as file:
            del file["networks/V"]
            write_network(file.create_group("networks/V"), V, bias=False)
        self.assertEqual(Run(self.path("run.h5")).V(np.zeros(2)), 0.0)

    def test_an_unverified_run_has_no_guarantee(self):
        synthetic_run(self.path("run.h5"))
        with h5py.File(self.path("run.h5"), "a") as file:
            for name in ("certificate", "evaluation", "timing", "rollouts", "grid", "history", "config"):
                del file[name]
        run = Run(self.path("run.h5"))
        self.assertEqual(
            (run.guarantee, run.certificate["conditions"], run.rollouts, run.grid), ("none", [], [], None)
        )

    def bad(self, expected, change):
        path = self.path("bad.h5")
        synthetic_run(path)
        with h5py.File(path, "a") as file:
            change(file)
        with self.assertRaisesRegex(RunError, expected) as caught:
            Run(path)
        self.assertNotIn("\n", str(caught.exception))
        self.assertIn(path, str(caught.exception))

    def test_bad_files_are_named(self):
        def replace(name, value):
            def change(file):
                del file[name]
                file[name] = value

            return change

        self.bad("schema_version: found 9, expected 5", lambda file: file.attrs.modify("schema_version", 9))
        self.bad("/networks: missing", lambda file: file.__delitem__("networks"))
        self.bad("weight_1", replace("networks/V/weight_1", np.zeros((5, 9))))
        self.bad("bias_0.*expected", replace("networks/B/bias_0", np.zeros(3)))
        self.bad("found 'relu'", lambda file: file["networks/f"].attrs.modify("activation_0", "relu"))
        self.bad("found 'cubed'", lambda file: file["networks/V"].attrs.modify("head", "cubed"))
        self.bad(
            "/networks/B: found 2 inputs and 3",
            lambda file: (
                file["networks"].__delitem__("B"),
                write_network(
                    file.create_group("networks/B"), random_network(np.random.default_rng(0), 2, 3)
                ),
            ),
        )
        self.bad("position.*expected", replace("data/demonstrations/2/position", np.zeros((60, 3))))
        self.bad("/data/test: found index 70", replace("data/test", [1, 70]))
        self.bad("/data/goals: found 3 rows, expected 7", replace("data/goals", np.zeros((3, 2))))
        self.bad("grid/B", replace("grid/B", np.zeros((3, 3))))

    def test_no_file_and_no_hdf5_file(self):
        with self.assertRaises(RunError):
            Run(self.path("absent.h5"))
        with open(self.path("text.h5"), "w", encoding="utf-8") as file:
            file.write("not HDF5")
        with self.assertRaises(RunError):
            Run(self.path("text.h5"))
        synthetic_run(self.path("run.h5"))
        with open(self.path("run.h5"), "rb") as file:
            content = file.read()
        with open(self.path("half.h5"), "wb") as file:
            file.write(content[: len(content) // 2])
        with self.assertRaises(RunError):
            Run(self.path("half.h5"))


class PlotTest(TemporaryFolder):
    def plot(self, expected, kind="png", **options):
        """Runs the program on a synthetic run; exactly the expected figures must be there, and not empty."""
        synthetic_run(self.path("run.h5"), **options)
        return self.figures(expected, kind)

    def figures(self, expected, kind="png"):
        out = self.path("figures")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            code = plot_run.main([self.path("run.h5"), "--out", out, "--format", kind])
        self.assertEqual(code, 0)
        paths = [os.path.join(out, f"{name}.{kind}") for name in expected]
        self.assertEqual(printed.getvalue().split("\n")[:-1], paths)
        self.assertEqual(sorted(os.listdir(out)), sorted(os.path.basename(path) for path in paths))
        for path in paths:
            with open(path, "rb") as file:
                content = file.read()
            self.assertGreater(len(content), 8000, path)
            if kind == "png":
                width, height = struct.unpack(">II", content[16:24])
                self.assertTrue(
                    content.startswith(b"\x89PNG") and 600 < width < 2500 and 300 < height < 2500, path
                )
            else:
                self.assertTrue(content.startswith(b"%PDF"), path)
        return paths

    def test_2d_and_same_run_same_figures(self):
        names = ["phase_portrait", "lyapunov", "history"]
        contents = []
        for paths in (self.plot(names, open_boxes=20, guarantee="sampled"), self.figures(names)):
            for path in paths:
                with open(path, "rb") as file:
                    contents.append(file.read())
        self.assertEqual(contents[:3], contents[3:])

    def test_pdf(self):
        self.plot(["phase_portrait", "lyapunov", "history"], kind="pdf")

    def test_3d(self):
        self.plot(["phase_portrait", "slices", "lyapunov", "history"], n=3, open_boxes=10, count=21)

    def test_the_history_leaves_out_what_is_zero_and_asks_one_question_a_panel(self):
        synthetic_run(self.path("run.h5"))
        panels = plot_run.history_panels(Run(self.path("run.h5")).history)
        self.assertEqual([list(columns) for _, columns, _ in panels], [
            ["their sum", "imitation"],
            ["barrier_decrease", "containment", "initial", "lyapunov_decrease", "unsafe"],
            ["rollouts that stay safe"],
        ])  # fmt: skip
        self.assertEqual(plot_run.history_panels({"round": np.arange(3), "seconds": np.ones(3)}), [])

    def test_one_round_without_grid(self):
        self.plot(["phase_portrait", "lyapunov", "history"], grid=False, rounds=1)
        shutil.rmtree(self.path("figures"))
        self.plot(["phase_portrait", "slices", "lyapunov", "history"], n=3, grid=False, rounds=1)

    def test_many_dimensions(self):
        self.plot(["phase_portrait", "lyapunov", "history"], n=4, open_boxes=3)

    def test_a_bare_run_with_a_lyapunov_function_below_zero_everywhere(self):
        synthetic_run(self.path("run.h5"))
        with h5py.File(self.path("run.h5"), "a") as file:
            for name in ("certificate", "evaluation", "rollouts", "history"):
                del file[name]
            file["grid/V"][...] = -1.0
        self.figures(["phase_portrait", "lyapunov"])

    def test_a_barrier_without_safe_set_and_a_lyapunov_function_below_zero_somewhere(self):
        synthetic_run(self.path("run.h5"))
        with h5py.File(self.path("run.h5"), "a") as file:
            file["grid/B"][...] = 1.0
            file["grid/V"][...] -= 0.5
            file["grid/unsafe"][...] = np.nan
            file["history/loss"][...] = np.nan
        with_digest(self.path("run.h5"))
        self.figures(["phase_portrait", "lyapunov", "history"])

    def test_the_readmes_picture_is_of_an_invariant_run_only(self):
        picture = self.path("picture.png")
        for guarantee, code in (("sampled", 2), ("invariant", 0)):
            synthetic_run(self.path("run.h5"), guarantee=guarantee)
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                self.assertEqual(readme_picture.main(["--run", self.path("run.h5"), "--out", picture]), code)
            self.assertEqual(os.path.exists(picture), code == 0)

    def fails(self, run, out):
        errors = io.StringIO()
        with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()) as printed:
            code = plot_run.main([run, "--out", out])
        self.assertEqual((code, errors.getvalue().count("\n"), printed.getvalue()), (2, 1, ""))

    def test_bad_input_is_one_line_and_code_2(self):
        self.fails(self.path("absent.h5"), self.path("figures"))
        self.assertFalse(os.path.exists(self.path("figures")))
        synthetic_run(self.path("run.h5"))
        self.fails(self.path("run.h5"), os.path.join(self.path("run.h5"), "inside_a_file"))


if __name__ == "__main__":
    unittest.main()
