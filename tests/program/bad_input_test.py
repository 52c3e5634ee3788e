#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Bad input gives one clear line on stderr and exit code 2, and overwrites nothing."""

import os
import resource
import shutil
import subprocess
import sys
import unittest

import command_line
import h5py
import numpy as np
import scipy.io
from command_line import SINE, ProgramTest, settings, torch_export

KEPT = b"an older result"


def lasa_motion(samples=50, demonstrations=4):
    """The cell array `demos` of a LASA file: arcs that end at (0, 0), in mm."""
    demos = np.empty((1, demonstrations), dtype=object)
    u = np.linspace(0.0, 1.0, samples)
    for k in range(demonstrations):
        position = np.vstack([-40.0 * (1.0 - u), (10.0 + k) * np.sin(np.pi * u)])
        demos[0, k] = {"pos": position, "t": 3.0 * u[None], "vel": np.gradient(position, 3.0 * u, axis=1)}
    return demos


def csv_rows(samples=20):
    u = np.linspace(0.0, 1.0, samples)
    return ["time,x,y"] + [f"{t:.17g},{t - 1.0:.17g},{0.2 * np.sin(np.pi * t):.17g}" for t in u]


class RefusedTraining(ProgramTest):
    """`train` is refused before it starts, so that an existing run file stays as it is."""

    def assert_train_refused(self, changes, *words, config=SINE):
        out = self.path("run.h5")
        with open(out, "wb") as file:
            file.write(KEPT)
        before = sorted(os.listdir(self.folder))
        result = self.call("train", config, *settings(changes), "--data", self.folder, "--out", out)
        self.assert_refused(result, *words)
        self.assertEqual(sorted(os.listdir(self.folder)), before)
        with open(out, "rb") as file:
            self.assertEqual(file.read(), KEPT)

    def write(self, name, rows):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write("\n".join(rows) + "\n")


class ProgramAlone(ProgramTest):
    def test_without_the_program_that_has_libtorch(self):
        """s2nnds is not linked to LibTorch; s2nnds-torch, which lies beside it otherwise, is."""
        alone = shutil.copy(command_line.PROGRAM, self.path("s2nnds"))
        done = subprocess.run([alone, "train", SINE], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assert_refused((done.returncode, done.stdout, done.stderr), os.path.join(self.folder, "s2nnds-torch"))
        done = subprocess.run([alone, "info", self.trained()], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


class ConfigTest(RefusedTraining):
    def test_no_config(self):
        self.assert_train_refused({}, "missing.toml", config=self.path("missing.toml"))

    def test_config_that_is_no_toml(self):
        self.write("broken.toml", ['name = "broken', "[data"])
        self.assert_train_refused({}, "broken.toml:1", config=self.path("broken.toml"))

    def test_misspelt_key(self):
        self.assert_train_refused({"training.raunds": 3}, "training.raunds", "rounds")

    def test_wrong_type(self):
        self.assert_train_refused({"training.rounds": '"many"'}, "training.rounds", "integer", "many")

    def test_negative_batch(self):
        self.assert_train_refused({"training.batch.demonstrations": -5}, "training.batch.demonstrations", "-5", ">=")

    def test_not_a_number(self):
        self.assert_train_refused({"training.rate_f": "nan"}, "training.rate_f", "nan")

    def test_unknown_choice(self):
        self.assert_train_refused({"networks.f.activation": '"step"'}, "networks.f.activation", "step", "tanh")

    def test_setting_without_a_value(self):
        result = self.call("train", SINE, "--set", "training.rounds", "--out", self.path("run.h5"))
        self.assert_refused(result, "training.rounds", "key=value")


class SetsTest(RefusedTraining):
    def unsafe(self, text):
        return {"problem.unsafe": text}

    def test_expression_that_does_not_parse(self):
        self.assert_train_refused(self.unsafe('{ type = "expression", level = "max(x, " }'), "problem.unsafe", "max(x, ")

    def test_expression_of_an_unknown_name(self):
        self.assert_train_refused(self.unsafe('{ type = "expression", level = "x + banana" }'), "banana")

    def test_expression_that_gives_nan(self):
        self.assert_train_refused(
            self.unsafe('{ type = "expression", level = "sqrt(x - 0.5)" }'), "problem.unsafe", "sqrt(x - 0.5)"
        )

    def test_obstacle_over_the_goal(self):
        self.assert_train_refused({"problem.unsafe.center": "[0.05, 0.0]"}, "problem.unsafe", "goal")

    def test_initial_set_meets_the_obstacle(self):
        self.assert_train_refused({"problem.unsafe.center": "[-0.93, 0.0]"}, "problem.initial", "unsafe set")

    def test_demonstrations_outside_the_workspace(self):
        self.assert_train_refused({"problem.workspace": 0.9}, "workspace", "demonstration")

    def test_centre_of_another_dimension(self):
        self.assert_train_refused({"problem.unsafe.center": "[0.5, 0.5, 0.5]"}, "problem.unsafe", "3", "2")


class DataTest(RefusedTraining):
    def mat(self, **changes):
        return {"data": '{ source = "lasa", file = "motion.mat", test = [3] }', **changes}

    def csv(self):
        return {"data": '{ source = "csv", files = ["a.csv", "b.csv"], test = [1] }'}

    def test_missing_mat(self):
        self.assert_train_refused(self.mat(), "motion.mat")

    def test_truncated_mat(self):
        scipy.io.savemat(self.path("motion.mat"), {"demos": lasa_motion(), "dt": 0.06})
        os.truncate(self.path("motion.mat"), os.path.getsize(self.path("motion.mat")) // 2)
        self.assert_train_refused(self.mat(), "motion.mat")

    def test_mat_of_something_else(self):
        scipy.io.savemat(self.path("motion.mat"), {"weather": np.ones((3, 3))})
        self.assert_train_refused(self.mat(), "motion.mat", "demos")

    def test_text_named_mat(self):
        self.write("motion.mat", ["no MATLAB file at all"])
        self.assert_train_refused(self.mat(), "motion.mat")

    def test_whole_mat_is_read(self):  # so that the refusals above are not for another reason
        scipy.io.savemat(self.path("motion.mat"), {"demos": lasa_motion(), "dt": 0.06})
        code, _, err = self.call(
            "train", SINE, *settings(self.mat()), "--data", self.folder, "--out", self.path("run.h5"), "--threads", 1
        )
        self.assertIn(code, (0, 3), err)

    def test_csv_with_nan(self):
        rows = csv_rows()
        self.write("a.csv", rows)
        self.write("b.csv", rows[:5] + ["0.2,nan,0.1"] + rows[6:])
        self.assert_train_refused({**self.csv(), "data.cleaning.missing": "false"}, "b.csv:6", "NaN")

    def test_csv_with_ragged_rows(self):
        rows = csv_rows()
        self.write("a.csv", rows)
        self.write("b.csv", rows[:5] + ["0.2,0.1"] + rows[6:])
        self.assert_train_refused(self.csv(), "b.csv")

    def test_csv_with_one_sample(self):
        self.write("a.csv", csv_rows())
        self.write("b.csv", csv_rows()[:2])
        self.assert_train_refused(self.csv(), "b.csv", "sample")

    def test_data_folder_that_is_not_there(self):
        result = self.call("train", SINE, "--data", self.path("nowhere"), "--out", self.path("run.h5"))
        self.assert_refused(result, "nowhere")
        self.assertEqual(os.listdir(self.folder), [])


class RunFileTest(ProgramTest):
    def assert_run_refused(self, run, *words, commands=("info", "verify", "evaluate", "export", "plot")):
        with open(run, "rb") as file:
            before = file.read()
        for command in commands:
            with self.subTest(command=command):
                self.assert_refused(self.call(command, run), *words)
        self.assert_refused(self.call("train", "--resume", run), *words)
        self.assertEqual(os.listdir(self.folder), [os.path.basename(run)])
        with open(run, "rb") as file:
            self.assertEqual(file.read(), before)

    def test_no_file(self):
        self.assert_refused(self.call("info", self.path("missing.h5")), "missing.h5")

    def test_not_hdf5(self):
        with open(self.path("run.h5"), "wb") as file:
            file.write(KEPT)
        self.assert_run_refused(self.path("run.h5"), "run.h5", "HDF5", commands=("info",))

    def test_another_schema(self):
        run = self.trained()
        with h5py.File(run, "r+") as file:
            file.attrs["schema_version"] = 99
        self.assert_run_refused(run, "run.h5", "schema 99", "schema 5")

    def test_truncated(self):
        run = self.trained()
        os.truncate(run, os.path.getsize(run) // 2)
        self.assert_run_refused(run, "run.h5")

    def test_weights_of_a_wrong_shape(self):
        run = self.trained()
        with h5py.File(run, "r+") as file:
            weight = file["networks/f/weight_1"][()]
            del file["networks/f/weight_1"]
            file["networks/f/weight_1"] = weight[:, :-1]
        self.assert_run_refused(run, "/networks/f", commands=("verify", "export"))

    def test_weights_that_are_not_finite(self):
        run = self.trained()
        with h5py.File(run, "r+") as file:
            file["networks/B/weight_0"][0, 0] = np.nan
        self.assert_run_refused(run, "/networks/B", commands=("verify",))

    def test_certificate_of_other_weights(self):
        run = self.trained()
        with h5py.File(run, "r+") as file:
            file["networks/B/bias_0"][0] += 1e-12
        for command in ("info", "evaluate", "plot", "export"):
            self.assert_refused(self.call(command, run), "certificate", "weights")
        self.assertEqual(os.listdir(self.folder), ["run.h5"])
        code, out, err = self.call("verify", run, "--method", "sampled", "--samples", 1000)
        self.assertIn(code, (0, 3), err)
        self.assertIn("a new one begins", err)
        self.assertEqual(self.call("info", run)[0], 0)

    def test_resume_without_a_checkpoint(self):
        run = self.trained()
        with h5py.File(run, "r+") as file:
            del file["checkpoint"]
        self.assert_refused(self.call("train", "--resume", run), "run.h5", "checkpoint")

    def test_resume_with_a_config_as_well(self):
        run = self.trained()
        self.assert_refused(self.call("train", SINE, "--resume", run))
        self.assert_refused(self.call("train", "--resume", run, "--seed", 3))


class OutputTest(ProgramTest):
    def test_folder_that_is_not_there(self):
        out = self.path("nowhere/run.h5")
        self.assert_refused(self.call("train", SINE, *settings(), "--out", out), out)
        run = self.trained()
        self.assert_refused(self.call("export", run, "--out", self.path("nowhere/run.pt")), "nowhere/run.pt")
        self.assert_refused(
            self.call("export", run, "--format", "header", "--out", self.path("nowhere/run.h")), "nowhere/run.h"
        )
        self.assertEqual(os.listdir(self.folder), ["run.h5"])

    def test_folder_in_place_of_a_file(self):
        os.mkdir(self.path("folder.h5"))
        self.assert_refused(self.call("train", SINE, *settings(), "--out", self.path("folder.h5")), "folder.h5")
        run = self.trained()
        for kind in ("header", "onnx", "pt2", "torchscript"):
            refused = self.call("export", run, "--format", kind, "--out", self.path("folder.h5"))
            self.assert_refused(refused, "folder.h5")

    def test_pythons_that_cannot_write_pt2(self):
        run = self.trained()
        os.makedirs(self.path("modules/torch"))

        def refused(*words, **variables):
            out = self.path("kept.pt2")
            with open(out, "wb") as file:
                file.write(KEPT)
            result = self.call("export", run, "--format", "pt2", "--out", out, variables=variables)
            self.assert_refused(result, "pt2: ", "S2NNDS_PYTHON", *words)
            self.assertEqual(sorted(os.listdir(self.folder)), ["kept.pt2", "modules", "run.h5"])
            with open(out, "rb") as file:
                self.assertEqual(file.read(), KEPT)

        def torch(text):
            with open(self.path("modules/torch/__init__.py"), "w", encoding="utf-8") as file:
                file.write(text)

        here = {"PYTHONPATH": self.path("modules"), "PYTHONDONTWRITEBYTECODE": "1"}
        refused("/nowhere/python3", "No such file", S2NNDS_PYTHON="/nowhere/python3")
        refused("exit code 1", S2NNDS_PYTHON="/bin/false")
        refused("found no output", S2NNDS_PYTHON="/bin/true")
        torch("__version__ = '1.13.1+cpu'")
        refused(sys.executable, "found Python 3.", "with torch 1.13.1+cpu, expected torch 2.6 or newer", **here)
        torch("raise ImportError('libcuda.so:\\nnot found')")
        refused("whose torch cannot be imported (libcuda.so: not found), expected torch 2.6 or newer", **here)
        torch("raise ModuleNotFoundError('torch', name='torch')")
        refused("without torch, expected torch 2.6 or newer", **here)
        torch("__version__ = '2.99'")
        refused("AttributeError", **here)

    def test_file_in_place_of_a_folder(self):
        with open(self.path("figures"), "wb") as file:
            file.write(KEPT)
        code, _, err = self.call("plot", self.trained(), "--out", self.path("figures"))
        self.assertEqual((code, err.count("\n")), (2, 1), err)

    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_folder_without_permission(self):
        os.mkdir(self.path("closed"), mode=0o500)
        self.assert_refused(self.call("train", SINE, *settings(), "--out", self.path("closed/run.h5")), "permission")


class FullDiskTest(ProgramTest):
    """A write that fails half way, by a limit on the size of files: the older file stays, nothing else does."""

    def limited(self, *words):
        limit = 40_000  # bytes; a run file has some 400,000
        return self.call(*words, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))

    def assert_kept(self, path):
        self.assertEqual(os.listdir(self.folder), [os.path.basename(path)])
        with open(path, "rb") as file:
            self.assertEqual(file.read(), KEPT)

    def test_train(self):
        out = self.path("run.h5")
        with open(out, "wb") as file:
            file.write(KEPT)
        code, stdout, err = self.limited("train", SINE, *settings(), "--threads", 1, "--out", out)
        self.assertEqual((code, stdout), (2, ""), err)
        *progress, last = err.splitlines()
        self.assertIn(f"s2nnds: {out}: cannot write", last)
        self.assertEqual([line for line in progress if line.startswith("s2nnds")], [])
        self.assert_kept(out)

    def test_verify(self):
        run = self.trained()
        with open(run, "rb") as file:
            before = file.read()
        self.assert_refused(self.limited("verify", run, "--method", "sampled", "--samples", 1000), run, "cannot write")
        self.assertEqual(os.listdir(self.folder), ["run.h5"])
        with open(run, "rb") as file:
            self.assertEqual(file.read(), before)

    def test_export(self):
        # Networks large enough for a policy beyond the limit.
        run = self.trained(changes={"networks.f.hidden": "[128, 128]"})
        out = self.path("run.out")
        with open(out, "wb") as file:
            file.write(KEPT)
        for kind in ("header", "onnx", "torchscript") if torch_export() else ("header", "onnx", "pt2", "torchscript"):
            self.assert_refused(self.limited("export", run, "--format", kind, "--out", out), out, "cannot write")
        os.remove(run)
        self.assert_kept(out)


class CommandTest(ProgramTest):
    def test_unknown_command(self):
        self.assert_refused(self.call("dance"), "dance")

    def test_no_command(self):
        self.assert_refused(self.call(), "subcommand")

    def test_unknown_option(self):
        self.assert_refused(self.call("train", SINE, "--fast"), "--fast")

    def test_option_without_its_value(self):
        self.assert_refused(self.call("train", SINE, "--out"), "--out")

    def test_unknown_method_and_format(self):
        self.assert_refused(self.call("verify", "run.h5", "--method", "guess"), "guess")
        self.assert_refused(self.call("export", "run.h5", "--format", "word"), "word")
        self.assert_refused(self.call("export", "run.h5", "--format", "header", "--precision", "half"), "half")

    def test_nothing_to_train(self):
        self.assert_refused(self.call("train"), "--resume")

    def test_help_is_no_error(self):
        code, out, err = self.call("--help")
        self.assertEqual((code, err), (0, ""))
        self.assertIn("verify", out)


SHIPPED = ("--set", 'data={source="handwriting", motion="Sine", test=[5, 6]}')  # data that need no file


class DriverTest(ProgramTest):
    """A driver of experiments/, which stands beside the program."""

    def drive(self, *words):
        driver = command_line.driver("cluttered_sine")
        done = subprocess.run(
            [driver, "--data", self.folder, "--no-figures", *words], cwd=self.folder, capture_output=True, text=True
        )
        return done.returncode, done.stdout, done.stderr

    def test_command_lines(self):
        for words, *expected in (
            (("--bogus",), "--bogus"),
            (("--seeds", "a"), "--seeds"),
            (("--seeds",), "--seeds"),
            (("--seeds", "1", "2", "1"), "1 twice", "once"),
            (("--jobs", "-3"), "--jobs"),
            (("--set", "seed=7"), "seed=7", "--seeds"),
            (("--set", "training.raunds=3"), "training.raunds"),
            (("--results", "no_such_folder/x.json"), "no_such_folder"),
        ):
            with self.subTest(words=words):
                self.assert_refused(self.drive("--out", "runs", *words), *expected, program="cluttered_sine")

    def test_out_is_a_file(self):
        with open(self.path("runs"), "wb") as file:
            file.write(KEPT)
        self.assert_refused(self.drive("--quick", "--out", "runs", *SHIPPED), "runs", "folder", program="cluttered_sine")
        with open(self.path("runs"), "rb") as file:
            self.assertEqual(file.read(), KEPT)

    def test_a_run_of_another_configuration_stays(self):
        os.mkdir(self.path("runs"))
        with open(self.path("runs/sweep.toml"), "w", encoding="utf-8") as file:
            file.write('name = "another"\n')
        result = self.drive("--quick", "--out", "runs", *SHIPPED)
        self.assert_refused(result, "another sweep", "another --out", program="cluttered_sine")
        with open(self.path("runs/sweep.toml"), encoding="utf-8") as file:
            self.assertEqual(file.read(), 'name = "another"\n')

    def test_data_that_are_not_there_leave_no_folder(self):
        self.assert_refused(self.drive("--quick", "--out", "runs"), "Sine.mat", program="cluttered_sine")
        self.assertFalse(os.path.exists(self.path("runs")))


if __name__ == "__main__":
    command_line.main()
