#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The reader, the figures and the notebook of sweeps, on a table that is made here."""

import contextlib
import io
import os
import shutil
import tempfile
import unittest

import h5py
import numpy as np
from execute_notebook import execute_notebook

from s2nnds import plot_sweep
from s2nnds.sweep import Sweep, SweepError, pareto_front
from test_plot import synthetic_run


def write_table(path, trials=24, guarantee="proved", **changes):
    rng = np.random.default_rng(3)
    point = np.arange(trials) // 2
    decay_rate = 10.0 ** rng.uniform(-2, 0, trials // 2)[point]
    columns = {
        "trial": np.arange(trials, dtype=float),
        "rung": np.zeros(trials),
        "point": point.astype(float),
        "config": np.array(["Sine", "Worm"] * (trials // 2), dtype=object),
        "seed": np.zeros(trials),
        "training.loss.decay_rate": decay_rate,
        "networks.f.hidden": np.array([["[8]", "[16, 16]", "[32, 32]"][k % 3] for k in point], dtype=object),
        "status": np.array(["failed"] + ["done"] * (trials - 1), dtype=object),
        "error": np.array(["problem.unsafe: covers the goal"] + [""] * (trials - 1), dtype=object),
        "guarantee": np.array(["none"] + ["proved", "invariant", "none"] * trials, dtype=object)[:trials],
        "counts": np.array(([0.0] + [1.0, 1.0, 0.0] * trials)[:trials]),
        "seconds": rng.uniform(5, 90, trials),
        "mse_validation": np.where(np.arange(trials) == 0, np.nan, 0.01 + decay_rate * rng.uniform(0.01, 0.2, trials)),
        "safe_area_ratio": rng.uniform(0.4, 1.0, trials),
        "seconds_training": rng.uniform(4, 80, trials),
        "run": np.array([f"runs/0000/{k:07d}.h5" for k in range(trials)], dtype=object),
        **changes,
    }
    with h5py.File(path, "w") as file:
        file.attrs.update(name="made", objective="mse_validation", direction="minimize", guarantee=guarantee, dtw_limit=0.1, share=0.5)
        text = h5py.string_dtype()
        file.attrs.create("axes", ["training.loss.decay_rate", "networks.f.hidden"], dtype=text)
        file.attrs.create("columns", list(columns), dtype=text)
        for name, values in columns.items():
            file.create_dataset(f"trials/{name}", data=values, dtype=text if values.dtype == object else None)
        file["trials/training.loss.decay_rate"].attrs.update(scale="log", values=np.array(["0.01", "1.0"], dtype=object))
        file["trials/networks.f.hidden"].attrs.update(scale="list", values=np.array(["[8]", "[16, 16]", "[32, 32]"], dtype=object))


class SweepTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="s2nnds-test-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.table = os.path.join(self.folder, "table.h5")

    def draw(self):
        printed, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
            code = plot_sweep.main([self.table, "--out", os.path.join(self.folder, "figures")])
        return code, [os.path.basename(path) for path in printed.getvalue().split() if path.endswith(".png")], errors.getvalue()

    def test_reader(self):
        write_table(self.table)
        sweep = Sweep(self.table)
        self.assertEqual((len(sweep), sweep.objective, int(sweep.done().sum())), (24, "mse_validation", 23))
        self.assertEqual(sweep["config"][1], "Worm")
        self.assertEqual(sweep.effect_rows[1], ("networks.f.hidden", "[8]", "[16, 16]"))
        self.assertEqual(sweep.run(3), os.path.join(self.folder, "runs/0000/0000003.h5"))

    def test_ranking_is_that_of_the_program(self):
        """As tests/sweeps/ranking_test.cpp: the guarantee's share first, then the geometric mean."""
        write_table(self.table, 6, counts=np.array([0, 0, 1, 0, 1, 1.0]), status=np.array(["done"] * 6, dtype=object),
                    mse_validation=np.array([0.001, 0.001, 0.4, 0.1, 0.01, 0.09]))
        ranking = Sweep(self.table).ranking()
        self.assertEqual([row[0] for row in ranking], [2, 1, 0])
        np.testing.assert_allclose([row[2] for row in ranking], [0.03, 0.2, 0.001])

    def study(self, noise, **changes):
        """120 trials of three problems: MSE = c_problem a^0.1 1.2^[letter = "[32, 32]"] e^noise."""
        rng = np.random.default_rng(7)
        rate = 10.0 ** rng.uniform(-2, 0, 120)
        hidden = np.array([["[8]", "[16, 16]", "[32, 32]"][k] for k in rng.integers(0, 3, 120)], dtype=object)
        problem = rng.permutation(np.arange(120) % 3)
        mse = 10.0 ** (problem - 3) * rate**0.1 * np.where(hidden == "[32, 32]", 1.2, 1.0) * np.exp(noise * rng.normal(size=120))
        columns = {"training.loss.decay_rate": rate, "networks.f.hidden": hidden, "mse_validation": mse,
                   "config": np.array(["a", "b", "c"], dtype=object)[problem], "counts": np.ones(120),
                   "status": np.array(["done"] * 120, dtype=object), "seconds": np.full(120, 10.0),
                   "safe_area_ratio": 0.9 - 0.05 * (hidden == "[16, 16]")}  # fmt: skip
        write_table(self.table, 120, **{**columns, **{name: change(columns) for name, change in changes.items()}})
        return Sweep(self.table).effects

    def test_effects_are_those_of_the_model_where_it_holds(self):
        effects = self.study(0.0)
        self.assertEqual(list(effects), ["mse_validation", "safe_area_ratio"])  # all count, and take as long
        error = effects["mse_validation"]
        self.assertEqual((error.kind, error.trials), ("factor", 120))
        np.testing.assert_allclose(error.change, [100**0.1, 1.0, 1.2], atol=1e-9)
        np.testing.assert_allclose(error.error, 0.0, atol=1e-9)
        self.assertEqual(effects["safe_area_ratio"].kind, "difference")
        np.testing.assert_allclose(effects["safe_area_ratio"].change, [0.0, -0.05, 0.0], atol=1e-9)

    def test_errors_say_how_far_effects_may_be_off(self):
        """Noise of .1 in the logarithm: a slope over its range has the standard error .1 sqrt(12 / 120) = .032, the
        difference of two thirds of the trials .1 sqrt(2 / 40) = .022."""
        effect = self.study(0.1)["mse_validation"]
        relative, expected = effect.error / effect.change, np.array([0.0316, 0.0224, 0.0224])
        np.testing.assert_allclose(relative, expected, rtol=0.3)
        off = np.abs(np.log(effect.change) - [0.1 * np.log(100), 0.0, np.log(1.2)])
        self.assertTrue(np.all(off < 4 * expected), off)

    def test_only_trials_that_count_are_measured_all_of_them_are_counted(self):
        effects = self.study(0.0, counts=lambda columns: (columns["networks.f.hidden"] != "[8]").astype(float))
        self.assertEqual(effects["counts"].trials, 120)
        np.testing.assert_allclose(effects["counts"].change, [0.0, 1.0, 1.0], atol=1e-9)
        self.assertNotIn("mse_validation", effects)  # no trial with "[8]" is left to compare with

    def test_few_trials_tell_no_effects(self):
        write_table(self.table, 4)
        self.assertEqual(Sweep(self.table).effects, {})

    def test_pareto_front(self):
        cost, gain = np.array([1, 2, 3, 4, 2, np.nan]), np.array([5, 3, 4, 1, 6, 0.0])
        self.assertEqual(list(pareto_front(cost, gain)), [0, 1, 3])

    def test_figures(self):
        write_table(self.table)
        self.assertEqual(self.draw(), (0, ["effects.png", "axes.png", "problems.png", "pareto.png"], ""))
        for name in ("effects.png", "axes.png", "problems.png", "pareto.png"):
            self.assertGreater(os.path.getsize(os.path.join(self.folder, "figures", name)), 8000)

    def test_factors_of_each_problems_median(self):
        values, problems = np.array([1.0, 10.0, 2.0, 20.0, 4.0]), np.array(["a", "b", "a", "b", "a"], dtype=object)
        np.testing.assert_allclose(plot_sweep.as_factors(values, problems), [0.5, 2 / 3, 1.0, 4 / 3, 2.0])

    def test_nothing_to_draw(self):
        write_table(self.table, status=np.array(["failed"] * 24, dtype=object), counts=np.zeros(24))
        self.assertEqual(self.draw(), (0, [], ""))

    def test_no_trial_has_the_guarantee(self):
        write_table(self.table, counts=np.zeros(24))
        self.assertEqual(self.draw()[0], 0)

    def test_bad_tables(self):
        with self.assertRaises(SweepError):
            Sweep(self.table)
        with open(self.table, "w", encoding="utf-8") as file:
            file.write("no table")
        code, _, errors = self.draw()
        self.assertEqual((code, errors.count("\n")), (2, 1))

    def test_notebook(self):
        write_table(self.table)
        os.makedirs(os.path.join(self.folder, "runs/0000"))
        for trial in range(24):
            synthetic_run(os.path.join(self.folder, f"runs/0000/{trial:07d}.h5"))
        executed = execute_notebook("sweep.ipynb", self.folder, S2NNDS_SWEEP=self.folder)
        self.assertEqual(executed.count('"image/png"'), 5)
        self.assertIn("covers the goal", executed)


if __name__ == "__main__":
    unittest.main()
