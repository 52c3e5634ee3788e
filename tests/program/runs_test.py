#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Training and verifying through the command line: reproducible, resumable, with the promised exit codes."""

import json
import os
import random
import signal
import time

import command_line
import h5py
import numpy as np
from command_line import CLOCKS, FAR_OBSTACLE, SINE, ProgramTest, differences, settings

KEYS = (
    "name seed guarantee conditions seconds mse_train mse_test sd_test safe_area true_safe_area run".split()
)


class SeedTest(ProgramTest):
    def train(self, name, *words):
        code, _, err = self.call("train", SINE, *settings(), "--out", self.path(name), *words)
        self.assertIn(code, (0, 3), err)
        return self.path(name)

    def test_same_seed_same_file(self):
        a, b = (self.train(name, "--seed", 7) for name in ("a.h5", "b.h5"))
        self.assertEqual(differences(a, b), [])

    def test_another_seed_another_file(self):  # or the comparison above would say nothing
        different = differences(self.train("a.h5", "--seed", 7), self.train("b.h5", "--seed", 8))
        for name in ("/networks/f/weight_0", "/networks/V/weight_0", "/networks/B/weight_0", "/history/loss"):
            self.assertIn(name, different)

    def test_comparison_leaves_out_clocks_alone(self):
        compared = command_line.contents(self.trained())
        measured = [name for name in compared if not name.startswith("/config/")]  # which has limits in seconds
        self.assertEqual([name for name in measured if "second" in name or "created" in name], [])
        for name in ("/history/loss", "/grid/B", "/certificate/@weight_hash", "/certificate/conditions/0/worst",
                     "/checkpoint/@round", "/@schema_version", "/config/text"):
            self.assertIn(name, compared, CLOCKS)


class ResumeTest(ProgramTest):
    """kill -9 at any moment, then --resume: the same file as that of an unbroken run."""

    CHANGES = {"training.rounds": 4, "training.min_rounds": 4}

    def begin(self, out):
        """The command that starts the run, or goes on with it once there is something to go on from."""
        if os.path.exists(out):
            return ("train", "--resume", out, "--threads", 1)
        return ("train", SINE, *settings(self.CHANGES), "--threads", 1, "--out", out)

    def kill_after(self, lines, seconds, out):
        """Starts the run or goes on with it; kill -9 `seconds` after its `lines`-th line of progress."""
        process = command_line.start(*self.begin(out), cwd=self.folder)
        for _ in range(lines):
            process.stderr.readline()
        time.sleep(seconds)
        process.send_signal(signal.SIGKILL)
        process.communicate()

    def test_killed_runs_end_like_unbroken_ones(self):
        began = time.monotonic()
        unbroken = self.trained("unbroken.h5", self.CHANGES)
        a_round = (time.monotonic() - began) / 8  # about: four rounds, the start and the end
        moments = random.Random(20240517)
        for attempt in range(4):
            out = self.path(f"killed-{attempt}.h5")
            plan = [(moments.randrange(0, 4), moments.uniform(0.0, a_round)) for _ in range(2)]
            with self.subTest(killed_after=plan):
                for lines, seconds in plan:
                    self.kill_after(lines, seconds, out)
                    if os.path.exists(out):  # a whole file, whatever the moment
                        self.assertIn(self.call("info", out)[0], (0, 3))
                code, _, err = self.call(*self.begin(out))
                self.assertIn(code, (0, 3), err)
                self.assertEqual(differences(unbroken, out), [])
                with h5py.File(out) as file:  # the clock goes on as well
                    self.assertTrue(np.all(np.diff(file["history/seconds"][:]) > 0.0))

    def test_resuming_a_finished_run_changes_nothing(self):
        unbroken, again = self.trained("a.h5"), self.trained("b.h5")
        code, _, err = self.call("train", "--resume", again, "--threads", 1)
        self.assertIn(code, (0, 3), err)
        self.assertEqual(differences(unbroken, again), [])

    def test_resuming_to_another_file_keeps_the_first(self):
        run = self.trained()
        with open(run, "rb") as file:
            before = file.read()
        code, _, err = self.call("train", "--resume", run, "--threads", 1, "--out", self.path("other.h5"))
        self.assertIn(code, (0, 3), err)
        with open(run, "rb") as file:
            self.assertEqual(file.read(), before)
        self.assertEqual(differences(run, self.path("other.h5")), [])


class TimingTest(ProgramTest):
    def first_clean_round(self, changes):
        """What the run says, and what its history says: the end of the first round, from 2, without counterexamples."""
        with h5py.File(self.trained(changes={"training.min_rounds": 2, **changes})) as file:
            history = {name: column[:] for name, column in file["history"].items()}
            told = file["timing"].attrs["first_clean_round"]
        found = sum(column for name, column in history.items() if name.startswith("count_"))
        clean = [second for k, second in enumerate(history["seconds"]) if k >= 2 and found[k] == 0]
        return told, clean[0] if clean else None

    def test_when_the_first_clean_round_ended(self):
        told, expected = self.first_clean_round(
            {**FAR_OBSTACLE, "training.steps": 300, "training.samples": 200, "training.rounds": 8}
        )
        self.assertIsNotNone(expected)
        self.assertEqual(told, expected)

    def test_no_time_without_a_clean_round(self):
        told, expected = self.first_clean_round({})
        self.assertIsNone(expected)
        self.assertTrue(np.isnan(told))


class JsonTest(ProgramTest):
    def last_line(self, *words):
        code, out, err = self.call(*words, "--json")
        self.assertIn(code, (0, 3), err)
        self.assertTrue(out.endswith("\n"))
        return code, json.loads(out.splitlines()[-1])

    def test_every_command_reports_the_same_keys(self):
        run = self.certified()
        for words in (
            ("train", "--resume", self.trained("resumed.h5")),
            ("verify", run, "--method", "sampled"),
            ("evaluate", run),
            ("info", run),
            ("export", run),
        ):
            with self.subTest(command=words[0]):
                _, report = self.last_line(*words)
                self.assertEqual([key for key in KEYS if key not in report], [])

    def test_values_are_those_of_the_file(self):
        run = self.certified()
        code, report = self.last_line("verify", run, "--method", "sampled", "--samples", 3000)
        self.assertEqual((code, report["guarantee"], report["name"], report["run"]), (0, "sampled", "Sine", run))
        verdicts = {name: entry["sampled"]["verdict"] for name, entry in report["conditions"].items()}
        self.assertEqual(set(verdicts.values()), {"passed"}, verdicts)
        self.assertEqual(report["conditions"]["lyapunov_decrease"]["sampled"]["samples"], 3000)
        with h5py.File(run) as file:
            self.assertEqual(file["certificate"].attrs["guarantee"], "sampled")
            self.assertEqual(file["evaluation"].attrs["mse_train"], report["mse_train"])
            self.assertEqual(file["certificate"].attrs["weight_hash"], report["weight_hash"])

    def test_one_setting_rules_all_threads(self):
        run = self.trained()
        for threads in (1, 2, 3):
            _, report = self.last_line("info", run, "--threads", threads)
            counts = report["threads"]
            self.assertEqual((counts["loops"], counts["aten"]), (threads, None))  # null: LibTorch is not loaded
            self.assertIn(counts["blas"], (None, 1))  # null: a BLAS without threads
        _, report = self.last_line("info", run)
        self.assertEqual(report["threads"]["loops"], len(os.sched_getaffinity(0)))

    def test_without_json_no_json(self):
        code, out, err = self.call("info", self.trained())
        self.assertEqual((code, err), (0, ""), out)
        self.assertFalse(out.splitlines()[-1].startswith("{"))


class InfoTest(ProgramTest):
    def test_the_first_screen_is_the_answer(self):
        run = self.certified()
        self.assertEqual(self.call("verify", run, "--method", "sampled")[0], 0)
        self.assertEqual(self.call("evaluate", run)[0], 0)
        code, out, err = self.call("info", run)
        self.assertEqual((code, err), (0, ""))
        self.assertLessEqual(len(out.splitlines()), 24, out)
        self.assertLessEqual(max(map(len, out.splitlines())), 100, out)
        self.assertEqual(out.splitlines()[0], "Sine (seed 0): guarantee SAMPLED")
        for words in ("No violation of any condition", "mm/s", "train", "test", "safe area", "disturbance", "time", run):
            self.assertIn(words, out)

    def test_all_tells_the_details(self):
        run = self.certified()
        code, out, err = self.call("info", run, "--all")
        self.assertEqual((code, err), (0, ""))
        with h5py.File(run) as file:
            for key in (*file["config/values"].attrs, *file["history"]):
                self.assertIn(f"  {key} ", out)
        self.assertTrue(out.startswith(self.call("info", run)[1].split("  --all")[0]))
        self.call("verify", run, "--method", "proof")
        table = self.call("info", run, "--all")[1].split("  proof ")[1].splitlines()
        self.assertEqual(len({len(line) for line in table[1:7]}), 1, "\n".join(table))  # columns align
        self.assertIn("goal_is_equilibrium", table[7])

    def test_version(self):
        code, out, err = self.call("--version")
        self.assertEqual((code, err), (0, ""))
        self.assertRegex(out, r"\As2nnds \d+\.\d+\.\d+ \(\w+\)\nLibTorch \d.*HDF5 \d.*Eigen \d")


class VerifyTest(ProgramTest):
    CONFORMAL = ("--method", "conformal", "--samples", 3000, "--epsilon", 0.01, "--beta", 0.01)

    def certificate(self, run, method=None):
        """Attributes of the certificate, and of its verdicts by this method, by condition."""
        with h5py.File(run) as file:
            attributes = dict(file["certificate"].attrs)
            verdicts = [dict(group.attrs) for group in file["certificate/conditions"].values()]
        return attributes, {v["condition"]: v for v in verdicts if v["method"] == method}

    def test_violated_conditions_are_not_verified(self):
        run = self.trained()
        code, out, err = self.call("verify", run, "--method", "sampled")
        self.assertEqual((code, err), (3, ""))
        self.assertIn("failed", out)
        self.assertIn("guarantee NONE", out)
        self.assertEqual(self.certificate(run)[0]["guarantee"], "none")

    def test_training_that_does_not_verify(self):
        code, out, _ = self.call("train", SINE, *settings(), "--threads", 1, "--out", self.path("run.h5"))
        self.assertEqual(code, 3)
        self.assertIn("guarantee NONE", out)

    def test_sampled(self):
        run = self.certified()
        code, out, err = self.call("verify", run, "--method", "sampled")
        self.assertEqual((code, err), (0, ""), out)
        self.assertIn("guarantee SAMPLED", out)
        certificate, verdicts = self.certificate(run, "sampled")
        self.assertEqual(certificate["guarantee"], "sampled")
        self.assertEqual({v["violations"] for v in verdicts.values()}, {0})
        self.assertGreaterEqual(len(verdicts), 5)

    def test_proof(self):
        run = self.certified()
        code, out, err = self.call("verify", run, "--method", "proof")
        self.assertEqual((code, err), (0, ""), out)
        certificate, verdicts = self.certificate(run, "proof")
        self.assertEqual(certificate["guarantee"], "invariant")
        self.assertEqual({v["verdict"] for v in verdicts.values()}, {"proved"})
        self.assertGreater(certificate["disturbance_margin"], 0.0)
        self.assertIn("proved", out)

    def test_proof_of_what_does_not_hold(self):
        run = self.certified()
        with h5py.File(run, "r+") as file:
            file["networks/B/bias_1"][0] = 0.5  # B > 0 everywhere, the initial set included
        code, out, err = self.call("verify", run, "--method", "proof")
        self.assertEqual((code, err), (3, ""), out)
        certificate, verdicts = self.certificate(run, "proof")
        self.assertEqual(certificate["guarantee"], "none")
        self.assertEqual(verdicts["initial"]["verdict"], "refuted")

    def test_conformal_twice_spends_less_of_beta(self):
        run = self.certified()
        code, out, _ = self.call("verify", run, *self.CONFORMAL)
        self.assertEqual(code, 0, out)
        first, verdicts_1 = self.certificate(run, "conformal")
        code, out, _ = self.call("verify", run, *self.CONFORMAL)
        self.assertEqual(code, 0, out)
        second, verdicts_2 = self.certificate(run, "conformal")
        self.assertEqual((first["guarantee"], first["attempts"]), ("conformal", 1))
        self.assertIn("a copy of the file begins anew", " ".join(out.split()))
        self.assertEqual((second["guarantee"], second["attempts"]), ("conformal", 2))
        sampled = [name for name, v in verdicts_1.items() if v["beta"] > 0]
        self.assertGreaterEqual(len(sampled), 4)
        for name in sampled:
            with self.subTest(condition=name):
                self.assertEqual((verdicts_1[name]["attempt"], verdicts_2[name]["attempt"]), (1, 2))
                self.assertLess(verdicts_2[name]["beta"], verdicts_1[name]["beta"])
                self.assertLessEqual(verdicts_2[name]["order"], verdicts_1[name]["order"])
                self.assertNotEqual(verdicts_2[name]["quantile"], verdicts_1[name]["quantile"])  # fresh samples
        # All attempts together spend no more than beta: 1/2 + 1/6 + ... = 1.
        spent = sum(v[name]["beta"] for v in (verdicts_1, verdicts_2) for name in sampled)
        self.assertAlmostEqual(spent, 0.01 * (1 / 2 + 1 / 6), places=12)

    def test_too_few_samples_for_conformal(self):
        run = self.certified()
        with open(run, "rb") as file:
            before = file.read()
        too_few = ("verify", run, "--method", "conformal", "--epsilon", 0.01, "--beta", 0.01, "--samples")
        result = self.call(*too_few, 100)
        self.assert_refused(result, "100")
        with open(run, "rb") as file:
            self.assertEqual(file.read(), before)
        # The number that it asks for is the least one: (1 - epsilon)^N <= the share of beta of one condition.
        needed = max(int(word) for word in result[2].replace(",", " ").replace(";", " ").split() if word.isdigit())
        self.assert_refused(self.call(*too_few, needed - 1), str(needed))
        code, out, err = self.call(*too_few, needed)
        self.assertEqual(code, 0, out + err)
        with h5py.File(run) as file:
            self.assertEqual(file["certificate"].attrs["attempts"], 1)  # a refused call is no attempt

    def test_conformal_finds_violations(self):
        run = self.trained()
        code, out, _ = self.call("verify", run, *self.CONFORMAL)
        self.assertEqual(code, 3, out)
        self.assertEqual(self.certificate(run)[0]["guarantee"], "none")

    def test_options_out_of_range(self):
        run = self.certified()
        for words in (("--epsilon", 0), ("--epsilon", 1.5), ("--beta", "nan"), ("--samples", -1)):
            with self.subTest(words=words):
                self.assert_refused(self.call("verify", run, "--method", "conformal", *words), words[0][2:])


class EvaluateTest(ProgramTest):
    @staticmethod
    def square_error(file, k):
        """The mean of |f(x) - xdot|^2 of f(x) = -x on a stored demonstration, in normalised units."""
        data, d = file["data"], file[f"data/demonstrations/{k}"]
        x = (d["position"][()] - data["goals"][k]) / data.attrs["position_scale"]
        return np.mean(np.sum((-x - d["velocity"][()] / data.attrs["velocity_scale"]) ** 2, axis=1))

    def test_evaluate_measures_the_stored_networks(self):
        run = self.certified()
        code, out, err = self.call("evaluate", run, "--json")
        self.assertEqual((code, err), (3, ""))  # not verified yet
        report = json.loads(out.splitlines()[-1])
        with h5py.File(run) as file:
            squares = [self.square_error(file, k) for k in file["data/train"][()]]
        self.assertAlmostEqual(report["mse_train"], np.mean(squares), places=9)
        self.assertGreater(report["safe_area"], 0.0)
        self.assertLessEqual(report["safe_area"], report["true_safe_area"])

    def test_evaluate_tells_the_demonstrations_of_splits_apart(self):
        run = self.certified()
        code, out, err = self.call("evaluate", run, "--splits", "test", "train", "--json")
        self.assertEqual((code, err), (3, ""))
        rows = json.loads(out.splitlines()[-1])["demonstrations"]
        with h5py.File(run) as file:
            wanted = [("test", k) for k in file["data/test"][()]] + [("train", k) for k in file["data/train"][()]]
            self.assertEqual([(row["split"], row["demonstration"]) for row in rows], wanted)
            for row in rows:
                self.assertAlmostEqual(row["mse"], self.square_error(file, row["demonstration"]), places=9)
        self.assert_refused(self.call("evaluate", run, "--splits", "tests"), "tests")


if __name__ == "__main__":
    command_line.main()
