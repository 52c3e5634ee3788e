#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs the notebooks on a small run of the program: test_notebooks.py S2NNDS."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from execute_notebook import execute_notebook

from s2nnds.plot_paper import main as plot_paper
from s2nnds.run import Run

HERE = os.path.dirname(os.path.abspath(__file__))
CONFIG = os.path.join(HERE, "../experiments/configs/handwriting/Sine.toml")
SMALL = ["training.warm_start.steps=200", "training.rounds=2", "training.min_rounds=2", "training.steps=20",
         "training.enlarge_rounds=0", "training.samples=2000", "training.rollout_points=200", "networks.f.hidden=[16, 16]",
         "networks.V.hidden=[16]", "networks.B.hidden=[16]", 'verification.method="sampled"',
         "evaluation.area_cells=40", "evaluation.grid_points=41"]  # fmt: skip


class Notebooks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.folder = cls.holder.name
        cls.run_file, cls.policy = os.path.join(cls.folder, "small.h5"), os.path.join(cls.folder, "small.pt")
        settings = [word for assignment in SMALL for word in ("--set", assignment)]
        done = subprocess.run([PROGRAM, "train", CONFIG, "--out", cls.run_file, *settings], capture_output=True, text=True)
        assert done.returncode in (0, 3), done.stderr
        subprocess.run([PROGRAM, "export", cls.run_file, "--format", "torchscript", "--out", cls.policy], check=True,
                       capture_output=True)  # fmt: skip

    @classmethod
    def tearDownClass(cls):
        cls.holder.cleanup()

    def test_run(self):
        executed = execute_notebook("run.ipynb", self.folder, S2NNDS_RUN=self.run_file)
        self.assertGreaterEqual(executed.count('"image/png"'), 3)
        self.assertIn("numpy and torch differ by", executed)

    def test_policy(self):
        executed = execute_notebook("policy.ipynb", self.folder, S2NNDS_POLICY=self.policy)
        self.assertEqual(executed.count('"image/png"'), 1)

    def test_paper(self):
        results = os.path.join(self.folder, "results.json")
        # As a driver that was started in the project's folder writes it.
        row = {"run": os.path.relpath(self.run_file, os.path.dirname(HERE)), "seed": 0, "profile": "", "test": []}
        with open(results, "w", encoding="utf-8") as file:
            rows = [row, {**row, "profile": "imitation"}]  # of these only certified runs are drawn
            json.dump({"experiment": "lasa_table", "created": "today", "program_version": "1", "seeds": [0], "runs": rows,
                       "tables": {"accuracy": {"head": ["motion"], "rows": [["Sine"]]}}}, file)  # fmt: skip
        executed = execute_notebook("paper.ipynb", self.folder, S2NNDS_RESULTS=results)
        self.assertEqual(executed.count('"image/png"'), 1)
        self.assertIn("1 of 1 run files are here", executed)

    def test_networks_as_torch(self):
        import torch

        run = Run(self.run_file)
        x = np.random.default_rng(1).uniform(-1, 1, (50, 2))
        for network in (run.f, run.V, run.B):
            np.testing.assert_allclose(network.torch()(torch.tensor(x)).detach().numpy(), network(x), atol=1e-12)

    def test_figures_of_several_runs(self):
        figure = os.path.join(self.folder, "panels.png")
        self.assertEqual(plot_paper(["panels", figure, self.run_file, self.run_file]), 0)
        self.assertGreater(os.path.getsize(figure), 10000)
        results = os.path.join(self.folder, "abc.json")
        line = {"coefficients": [-1.0], "exponents": [[1, 0]]}, {"coefficients": [-1.0], "exponents": [[0, 1]]}
        published = {"motion": Run(self.run_file).name, "mse_test": 0.1, "f": line,
                     "B": [{"coefficients": [1.0, 1.0, -0.5], "exponents": [[2, 0], [0, 2], [0, 0]]}]}  # fmt: skip
        with open(results, "w", encoding="utf-8") as file:
            json.dump({"abc_ds": [published]}, file)
        self.assertEqual(plot_paper(["against", figure, results, self.run_file]), 0)
        self.assertEqual(plot_paper(["panels", figure, "missing.h5"]), 2)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
