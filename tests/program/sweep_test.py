#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Sweeps through the command line: the same trials whatever happens on the way, and nothing lost."""

import csv
import json
import os
import signal
import time

import command_line
import h5py
import numpy as np
from command_line import PROJECT, SINE, SMALL, ProgramTest, differences

TRIAL = {**SMALL, "networks.f.hidden": "[8]", "networks.V.hidden": "[8]", "networks.B.hidden": "[8]",
         "training.rounds": 2, "training.min_rounds": 1, "training.steps": 5, "training.warm_start.steps": 5,
         "training.rollout_points": 0, "training.samples": 100, "verification.sampled.samples": 100,
         "evaluation.grid_points": 11, "data.validation": "[4]"}


def toml(values):
    return "".join(f"{key} = {value}\n" for key, value in values.items())


def sweep_text(axes='"training.loss.decay_rate" = [0.1, 0.2]', changes=None, **fields):
    """A sweep whose trials take half a second each."""
    settings = {**TRIAL, **(changes or {})}
    own = {
        "name": '"tiny"',
        "configs": f'["{SINE}"]',
        "seeds": "[0, 1]",
        "set": json.dumps([f"{key}={value}" for key, value in settings.items()]),
        "objective": '"mse_validation"',
    }
    nested = toml({**own, **fields})
    return f"{nested}\n[axes]\n{axes}\n"


class SweepTest(ProgramTest):
    def write(self, text, name="sweep.toml"):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def sweep(self, *words, codes=(0, 3), out="out"):
        code, printed, err = self.call("sweep", self.path("sweep.toml"), "--out", self.path(out), *words)
        self.assertIn(code, codes, err + printed)
        return printed, err

    def rows(self, out="out"):
        with open(self.path(f"{out}/table.csv"), encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def result(self, trial, out="out"):
        with open(self.path(f"{out}/runs/0000/{trial:07d}.json"), encoding="utf-8") as file:
            return json.load(file)

    def run_file(self, trial, out="out"):
        return self.path(f"{out}/runs/0000/{trial:07d}.h5")


class DryRunTest(SweepTest):
    def trials(self, text):
        self.write(text)
        printed, _ = self.sweep("--dry-run", "--json", codes=(0,))
        self.assertFalse(os.path.exists(self.path("out")))
        return json.loads(printed.splitlines()[-1])["trials"]

    def test_lists_every_trial_and_starts_none(self):
        trials = self.trials(sweep_text('"training.loss.decay_rate" = [0.1, 0.2]\ntraining.steps = { range = [5, 7], count = 3 }'))
        self.assertEqual(len(trials), 12)
        self.assertEqual([t["seed"] for t in trials[:3]], [0, 1, 0])
        self.assertEqual(trials[2]["settings"][-3:], ["training.loss.decay_rate=0.1", "training.steps=6", "seed=0"])
        self.assertEqual(len({json.dumps(t["settings"]) for t in trials}), 12)

    def test_the_sweeps_of_this_project_and_every_design_of_their_readme(self):
        folder = os.path.join(PROJECT, "experiments/sweeps")
        with open(os.path.join(folder, "handwriting.toml"), encoding="utf-8") as file:
            example = file.read().replace("../configs", os.path.join(PROJECT, "experiments/configs"))
        for lines, trials in (
            ("", 12),
            ('design = "random"\npoints = 16', 32),
            ('design = "sobol"\npoints = 16', 32),
            ('design = "sobol"\npoints = 16\ncrossed = false', 16),
            ('halving = { key = "training.rounds", budgets = [8, 16, 40], keep = 0.33 }', 12),
        ):
            self.assertEqual(len(self.trials(example.replace("[axes]", lines + "\n[axes]"))), trials, lines)
        listed = '[[trials]]\nconfig = "S"\nseed = 3\nprofile = "imitation"\ntest = [1, 5]\n'
        trials = self.trials('design = "list"\n' + example[: example.index("[axes]")] + listed)
        self.assertEqual([(trial["config"], trial["seed"]) for trial in trials], [("S", 3)])
        self.assertIn("data.test=[1, 5]", trials[0]["settings"])
        code, _, err = self.call("sweep", os.path.join(folder, "default.toml"), "--dry-run")
        self.assertEqual(code, 0, err)

    def test_the_lines_for_people(self):
        self.write(sweep_text())
        printed, err = self.sweep("--dry-run", codes=(0,))
        self.assertEqual(err, "")
        self.assertIn("2 points (grid) x 1 configurations x 2 seeds = 4 trials", printed)
        self.assertEqual(len(printed.splitlines()), 5)


class LocalTest(SweepTest):
    def test_every_trial_stands_alone(self):
        """Tables agree with each other and with the run files, which their own configurations reproduce."""
        self.write(sweep_text())
        printed, err = self.sweep("--json", codes=(0,))
        summary = json.loads(printed.splitlines()[-1])
        self.assertEqual((summary["ended"], summary["failed"], summary["missing"]), (4, 0, 0))
        self.assertIn("4/4 ", err)
        self.assertIn("best=", err)
        rows = self.rows()
        self.assertEqual([(r["trial"], r["seed"], r["training.loss.decay_rate"]) for r in rows],
                         [("0", "0", "0.1"), ("1", "1", "0.1"), ("2", "0", "0.2"), ("3", "1", "0.2")])
        for row in rows:
            with h5py.File(self.path("out/" + row["run"])) as file:
                self.assertEqual(float(row["mse_validation"]), file["evaluation"].attrs["mse_validation"])
                self.assertEqual(float(row["mse_train"]), file["evaluation"].attrs["mse_train"])
                self.assertEqual(list(file["data/validation"]), [4])
                self.assertEqual(list(file["data/train"]), [0, 1, 2, 3])
        with h5py.File(self.run_file(3)) as file:
            config = self.write(file["config/text"].asstr()[()], "alone.toml")
        code, _, err = self.call("train", config, "--threads", 1, "--out", self.path("alone.h5"))
        self.assertEqual(code, 3, err)
        self.assertEqual(differences(self.path("alone.h5"), self.run_file(3)), [])

    def test_csv_and_hdf5_hold_the_same(self):
        self.write(sweep_text('"training.loss.decay_rate" = [0.1]\n"networks.f.hidden" = [[8], [4, 4]]'))
        self.sweep()
        rows = self.rows()
        with h5py.File(self.path("out/table.h5")) as file:
            self.assertEqual(list(file.attrs["columns"]), list(rows[0]))
            self.assertEqual(list(file.attrs["axes"]), ["training.loss.decay_rate", "networks.f.hidden"])
            for name in rows[0]:
                column = file["trials"][name]
                if column.dtype.kind == "O":
                    self.assertEqual(list(column.asstr()), [row[name] for row in rows])
                else:
                    np.testing.assert_array_equal(column[()], [float(row[name] or "nan") for row in rows])
        self.assertEqual({row["networks.f.hidden"] for row in rows}, {"[8]", "[4, 4]"})

    def test_a_failing_trial_leaves_the_others_alone(self):
        self.write(sweep_text('"problem.unsafe.center" = [[0.05, 0.0], [0.5, 0.5]]', seeds="[0]"))
        _, err = self.sweep()
        failed, done = self.rows()
        self.assertEqual((failed["status"], done["status"]), ("failed", "done"))
        self.assertIn("covers the goal", failed["error"])
        self.assertIn("trial=0 failed: problem.unsafe", err)
        self.sweep()  # what failed is not tried again
        before = os.stat(self.path("out/runs/0000/0000000.json")).st_mtime_ns
        self.sweep("--retry-failed")
        self.assertGreater(os.stat(self.path("out/runs/0000/0000000.json")).st_mtime_ns, before)

    def test_no_trial_with_the_guarantee_is_code_3(self):
        self.write(sweep_text(seeds="[0]", guarantee='"sampled"'))
        self.sweep(codes=(3,))

    def test_trials_whose_motion_goes_elsewhere_do_not_count(self):
        self.write(sweep_text('"training.steps" = [1, 20]', seeds="[0]"))
        self.sweep(codes=(0,))
        near, far = sorted(float(row["dtw_train"]) for row in self.rows())
        self.assertLess(near, far)
        with h5py.File(self.run_file(0)) as file:
            self.assertEqual(file["evaluation"].attrs["dtw_train"], float(self.rows()[0]["dtw_train"]))
        self.write(sweep_text('"training.steps" = [1, 20]', seeds="[0]", dtw_limit=0.5 * (near + far)))
        self.sweep(codes=(0,), out="limited")
        self.assertEqual(sorted((float(row["dtw_train"]), row["counts"]) for row in self.rows("limited")),
                         [(near, "1"), (far, "0")])
        self.write(sweep_text('"training.steps" = [1, 20]', seeds="[0]", dtw_limit=0.5 * near))
        self.sweep(codes=(3,), out="none")

    def test_halving_goes_on_where_the_rung_before_stopped(self):
        axes = '"training.rate_f" = { log_range = [1e-4, 1e-2], count = 4 }'
        changes = {"training.min_rounds": 3}  # so that none stops earlier
        self.write(sweep_text(axes, changes, seeds="[0]", halving="{ budgets = [1, 3], keep = 0.5 }"))
        printed, _ = self.sweep()
        self.assertIn("rung 2 of 2", printed)
        rows = self.rows()
        self.assertEqual([int(row["rung"]) for row in rows], [0, 0, 0, 0, 1, 1])
        first = sorted(rows[:4], key=lambda row: float(row["mse_validation"]))
        self.assertEqual({row["point"] for row in rows[4:]}, {row["point"] for row in first[:2]})
        self.assertEqual([int(row["rounds"]) for row in rows], [1, 1, 1, 1, 3, 3])
        trial = int(rows[4]["trial"])
        with h5py.File(self.run_file(trial)) as file:
            config = self.write(file["config/text"].asstr()[()], "alone.toml")
        self.call("train", config, "--threads", 1, "--out", self.path("alone.h5"))
        self.assertEqual(differences(self.path("alone.h5"), self.run_file(trial)), [])

    def test_report(self):
        self.write(sweep_text())
        self.sweep()
        printed, _ = self.sweep("--report")
        self.assertIn("rank", printed)
        self.assertEqual(sorted(os.listdir(self.path("out/figures"))), ["axes.png", "effects.png", "pareto.png"])

    def test_one_run_a_point_tells_effects_instead_of_ranks(self):
        axes = '"training.rate_f" = { log_range = [1e-4, 1e-2] }\n"networks.f.hidden" = [[8], [9]]'
        fields = {"design": '"sobol"', "crossed": "false", "points": 7}
        self.write(sweep_text(axes, **fields))
        printed, _ = self.sweep("--json", codes=(0,))
        self.assertNotIn("rank", printed)
        summary = json.loads(printed.splitlines()[-1])
        self.assertIsNone(summary["best"])
        rows = self.rows()
        self.assertEqual([row["point"] for row in rows], [str(k) for k in range(7)])
        for first in (0, 2, 4):  # the two seeds take turns
            self.assertEqual({row["seed"] for row in rows[first : first + 2]}, {"0", "1"})
        with h5py.File(self.path("out/table.h5")) as file:
            ranges = [dict(file["trials"][name].attrs) for name in file.attrs["axes"]]
            self.assertEqual([(axis["scale"], list(axis["values"])) for axis in ranges],
                             [("log", ["0.0001", "0.01"]), ("list", ["[8]", "[9]"])])
        printed, _ = self.sweep("--report")
        self.assertIn("mse_validation (7)", printed)
        self.assertIn("training.rate_f, 0.0001 -> 0.01", printed)

        # The same with more points keeps what there is; with fewer it is another sweep.
        before = os.stat(self.path("out/runs/0000/0000003.json")).st_mtime_ns
        self.write(sweep_text(axes, **{**fields, "points": 9}))
        self.sweep()
        self.assertEqual(os.stat(self.path("out/runs/0000/0000003.json")).st_mtime_ns, before)
        self.assertEqual(self.rows()[:7], rows)
        self.assertEqual(len(self.rows()), 9)
        self.write(sweep_text(axes, **{**fields, "points": 8}))
        self.assert_refused(self.call("sweep", self.path("sweep.toml"), "--out", self.path("out")), "another sweep", "more points")


class InterruptionTest(SweepTest):
    # Long enough for a signal to meet them: six rounds of about 0.2 s.
    CHANGES = {"training.rounds": 6, "training.min_rounds": 6, "training.steps": 400}

    def start(self):
        return command_line.start("sweep", self.path("sweep.toml"), "--out", self.path("out"), "--jobs", 2, cwd=self.folder)

    def wait_for(self, condition, what):
        for _ in range(600):
            if condition():
                return
            time.sleep(0.05)
        self.fail(f"waited 30 s for {what}")

    def processes(self):
        found = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/cmdline", encoding="utf-8") as file:
                    if self.path("out") in file.read():
                        found.append(int(pid))
            except OSError:
                pass
        return found

    def disturbed(self, number):
        """A sweep that is ended by the signal once trials are under way, and then called again."""
        self.write(sweep_text(changes=self.CHANGES))
        process = self.start()
        self.wait_for(lambda: os.path.exists(self.run_file(0)), "trial 0")
        process.send_signal(number)
        process.communicate()
        self.wait_for(lambda: not self.processes(), "the trials' processes to end with it")
        self.assertFalse(os.path.exists(self.path("out/runs/0000/0000003.json")))
        self.assertTrue(os.path.exists(self.run_file(0)))
        self.sweep()
        self.assertEqual([row["status"] for row in self.rows()], ["done"] * 4)
        return process.returncode

    def assert_as_undisturbed(self):
        self.sweep(out="undisturbed")
        for trial in range(4):
            self.assertEqual(differences(self.run_file(trial), self.run_file(trial, "undisturbed")), [])

    def test_kill_9_loses_the_running_rounds_at_most(self):
        self.assertEqual(self.disturbed(signal.SIGKILL), -signal.SIGKILL)
        self.assert_as_undisturbed()

    def test_ctrl_c(self):
        self.assertEqual(self.disturbed(signal.SIGINT), 130)

    def test_a_killed_trial_goes_on_and_a_trial_that_is_always_killed_fails(self):
        self.write(sweep_text(changes=self.CHANGES))
        process = self.start()
        self.wait_for(lambda: os.path.exists(self.run_file(0)), "trial 0")
        for pid in self.processes():
            with open(f"/proc/{pid}/cmdline", encoding="utf-8") as file:
                if "--trial\x000\x00" in file.read():
                    os.kill(pid, signal.SIGKILL)
        _, err = process.communicate()
        self.assertIn("trial=0 was killed by signal 9", err)
        self.assertEqual([row["status"] for row in self.rows()], ["done"] * 4)

        suicide = self.path("suicide")
        with open(suicide, "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\nkill -9 $$\n")
        os.chmod(suicide, 0o755)
        self.sweep("--program", suicide, out="lost")
        self.assertEqual({row["error"] for row in self.rows("lost")}, {"killed by signal 9, 3 times"})

    def test_two_sweeps_in_one_folder(self):
        self.write(sweep_text(changes=self.CHANGES))
        process = self.start()
        self.wait_for(lambda: os.path.exists(self.path("out/lock")), "the first sweep")
        time.sleep(0.3)
        result = self.call("sweep", self.path("sweep.toml"), "--out", self.path("out"))
        process.send_signal(signal.SIGTERM)
        process.communicate()
        self.assert_refused(result, "another sweep is running")


class BadInputTest(SweepTest):
    def assert_sweep_refused(self, text, *words, options=()):
        self.write(text)
        before = sorted(os.listdir(self.folder))
        self.assert_refused(self.call("sweep", self.path("sweep.toml"), "--out", self.path("out"), *options), *words)
        self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_files(self):
        self.assert_refused(self.call("sweep", self.path("missing.toml")), "missing.toml")
        self.assert_sweep_refused("name = 'a", "sweep.toml:1")
        self.assert_sweep_refused(sweep_text(configs='["nowhere.toml"]'), "nowhere.toml")
        self.assert_sweep_refused(sweep_text(configs="[]"), "configs")
        self.assert_sweep_refused(sweep_text(configs=f'["{SINE}", "{SINE}"]'), "twice")

    def test_misspelt_keys(self):
        self.assert_sweep_refused(sweep_text(objectiv='"mse_train"'), "sweep.toml:6", "objectiv", "objective")
        self.assert_sweep_refused(sweep_text('"training.loss.decay_rat" = [0.1]'), "sweep.toml:8", "decay_rat", "decay_rate")
        self.assert_sweep_refused(sweep_text('"training.steps" = { rnage = [1, 2] }'), "training.steps.rnage")
        self.assert_sweep_refused(sweep_text('"training.steps" = { range = [1, 2], cuont = 2 }'), "cuont", "count")
        self.assert_sweep_refused(sweep_text(set='["training.raunds=3"]'), "training.raunds", "rounds")

    def test_values(self):
        self.assert_sweep_refused(sweep_text('"training.loss.decay_rate" = [0.1, -1.0]'), "decay_rate", "-1", ">= 0")
        self.assert_sweep_refused(sweep_text('"training.steps" = [100, "many"]'), "many", "integer")
        self.assert_sweep_refused(sweep_text('"training.steps" = { range = [0.5, 7.5], count = 3 }'), "0.5", "integer")
        self.assert_sweep_refused(sweep_text('"training.steps" = []'), "at least one value")
        self.assert_sweep_refused(sweep_text('"training.steps" = [7, 7]'), "7 twice")
        self.assert_sweep_refused(sweep_text('"training.loss.decay_rate" = { range = [2, 1], count = 3 }'), "rises")
        self.assert_sweep_refused(sweep_text('"training.loss.decay_rate" = { log_range = [0.0, 1.0], count = 3 }'), "> 0")
        self.assert_sweep_refused(sweep_text('"training.loss.decay_rate" = { range = [0.0, 1.0] }'), "count")
        self.assert_sweep_refused(sweep_text('"seed" = [1, 2]'), "seed", "elsewhere")
        self.assert_sweep_refused(sweep_text(design='"sobol"'), "points")
        self.assert_sweep_refused(sweep_text(design='"gird"'), "gird", "grid")
        self.assert_sweep_refused(sweep_text(crossed="false", halving="{ budgets = [1, 3] }"), "halving", "crossed")

    def test_no_choice_by_test_demonstrations(self):
        self.assert_sweep_refused(sweep_text(objective='"mse_test"'), "mse_test", "mse_validation")

    def test_validation_that_nobody_holds_out(self):
        self.assert_sweep_refused(sweep_text(changes={"data.validation": "[]"}), "data.validation")

    def test_options(self):
        self.assert_sweep_refused(sweep_text(), "--only", options=("--dry-run", "--report"))
        self.assert_sweep_refused(sweep_text(), "no sweep", options=("--report",))

    def test_slurm_options(self):
        self.write(sweep_text())
        for spec, word in (("partitoin=a", "partitoin"), ("throttle=no", "throttle"), ("time", "name=value")):
            self.assert_refused(
                self.call("sweep", self.path("sweep.toml"), "--out", self.path("out"), "--slurm", spec), word
            )

    def test_another_sweep_in_the_folder(self):
        self.write(sweep_text(seeds="[0]"))
        self.sweep()
        self.write(sweep_text('"training.loss.decay_rate" = [0.3]', seeds="[0]"))
        self.assert_refused(self.call("sweep", self.path("sweep.toml"), "--out", self.path("out")), "another sweep")


if __name__ == "__main__":
    command_line.main()
