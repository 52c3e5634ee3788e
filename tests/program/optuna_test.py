#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Optuna chooses the settings of trials that the command line runs. Skipped where there is no optuna; S2NNDS_PYTHON names
a Python that has it."""

import json
import os
import subprocess
import sys
import tomllib
import unittest

import command_line
import h5py
from command_line import PROJECT
from sweep_test import SweepTest, sweep_text

PYTHON = os.environ.get("S2NNDS_PYTHON", sys.executable)
HAS_OPTUNA = subprocess.run([PYTHON, "-c", "import optuna"], capture_output=True, check=False).returncode == 0


@unittest.skipUnless(HAS_OPTUNA, f"{PYTHON} has no optuna")
class OptunaTest(SweepTest):
    def optuna(self, trials, code=0):
        script = os.path.join(PROJECT, "notebooks_export/optuna_sweep.py")
        done = subprocess.run(
            [PYTHON, script, self.path("sweep.toml"), "--trials", str(trials), "--out", self.path("study"), "--program",
             command_line.PROGRAM],
            capture_output=True, text=True, timeout=300, check=False,
        )
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout.splitlines()[-1]) if code == 0 else done.stdout

    def test_asks_and_tells_and_goes_on(self):
        axes = ('"training.rate_f" = { log_range = [1e-4, 1e-2] }\n"networks.f.hidden" = [[8], [4, 4]]\n'
                "training.steps = { range = [5, 9] }")
        self.write(sweep_text(axes, seeds="[0]"))
        self.optuna(2)
        best = self.optuna(4)
        runs = sorted(name for name in os.listdir(self.path("study")) if name.endswith(".h5"))
        self.assertEqual(runs, [f"{k:05d}-0.h5" for k in range(4)])
        errors = []
        for run in runs:
            code, out, _ = self.call("info", self.path(f"study/{run}"), "--json")
            errors.append(json.loads(out.splitlines()[-1])["mse_validation"])
        self.assertEqual((best["mse_validation"], best["trial"]), (min(errors), errors.index(min(errors))))
        self.assertIn(best["settings"]["networks.f.hidden"], ("[8]", "[4, 4]"))
        self.assertIn(best["settings"]["training.steps"], range(5, 10))

    def test_conformal_runs_share_beta(self):
        axes = '"training.rate_f" = [1e-3, 2e-3]'
        self.write(sweep_text(axes, changes={"verification.method": '"conformal"', "verification.conformal.beta": 0.02}))
        self.optuna(3)
        for run in (name for name in os.listdir(self.path("study")) if name.endswith(".h5")):
            with h5py.File(self.path(f"study/{run}")) as file:
                config = tomllib.loads(file["config/resolved"][()].decode())
            self.assertAlmostEqual(config["verification"]["conformal"]["beta"], 0.02 / 6)
        self.optuna(2)  # nothing is left to do
        script = self.optuna(4, code=1)
        self.assertEqual(script, "")

    def test_other_runs_keep_beta(self):
        self.write(sweep_text('"training.rate_f" = [1e-3, 2e-3]', seeds="[0]"))
        self.optuna(1)
        with h5py.File(self.path("study/00000-0.h5")) as file:
            config = tomllib.loads(file["config/resolved"][()].decode())
        self.assertEqual(config["verification"]["conformal"]["beta"], 1e-4)

    def test_no_trial_that_counts_is_code_3(self):
        self.write(sweep_text(seeds="[0]", dtw_limit=1e-9))
        self.assertIn("in no trial", self.optuna(1, code=3))


if __name__ == "__main__":
    command_line.main()
