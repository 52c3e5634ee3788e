#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The quickstart's certificate by s2nnds-check: the run, its proof and its exported policies, and each with one changed
weight. S2NNDS_CHECK is the checker's path."""

import os
import re
import shutil
import subprocess
import unittest

import command_line
import h5py
import numpy as np
from command_line import SINE, ProgramTest, torch_export

WEIGHT, PLACE = "networks/f/weight_1", (3, 4)


class CheckTest(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.run_file = os.path.join(cls.store, "sine.h5")
        cls.proof = os.path.join(cls.store, "proof.h5")
        for words in (("train", SINE, "--out", cls.run_file, "--until", "certified", "--set",
                       "evaluation.area_cells=20"),
                      ("verify", cls.run_file, "--method", "proof", "--artifact", cls.proof)):
            code, _, err = command_line.call(*words, cwd=cls.store)
            assert code == 0, err

    def check(self, *files):
        done = subprocess.run([os.environ["S2NNDS_CHECK"], *files], capture_output=True, text=True, timeout=300,
                              check=False)
        return done.returncode, done.stdout, done.stderr

    def test_shows_the_run_and_its_proof(self):
        for path in (self.run_file, self.proof):
            with self.subTest(path=os.path.basename(path)):
                code, out, err = self.check(path)
                self.assertEqual(code, 0, out + err)
                self.assertIn("Checked: every motion xdot = f(x) that starts in {B <= 0}", out)

    def test_shows_neither_with_one_changed_weight(self):
        for path in (self.run_file, self.proof):
            with self.subTest(path=os.path.basename(path)):
                changed = shutil.copyfile(path, self.path("changed.h5"))
                with h5py.File(changed, "r+") as file:
                    file[WEIGHT][PLACE] = np.nextafter(file[WEIGHT][PLACE], 1.0)
                code, out, err = self.check(changed)  # HDF5 has cut the hash of the file's bytes
                self.assertEqual((code, out, err.count("\n")), (2, "", 1), err)
                self.assertIn("other weights than those that the problem's text names", err)

    def changed_policy(self, kind, data):
        """The exported policy's bytes with WEIGHT at PLACE changed by its last digit."""
        real = np.float64 if kind == "pt2" else np.float32
        with h5py.File(self.run_file) as file:
            weight = real(file[WEIGHT][PLACE])
        other = np.nextafter(weight, real(1.0))
        if not kind.startswith("header"):
            old, new = weight.tobytes(), other.tobytes()
            self.assertEqual(data.count(old), 1)
            return data.replace(old, new)
        text = data.decode()
        array = text.index("f_weight_1[")
        number = next(found for found in re.finditer(r"[-+.\de]+(?=F?[,\s}])", text[text.index("{", array):])
                      if np.float32(found.group()) == weight)
        at = text.index("{", array) + number.start()
        return (text[:at] + repr(float(other)) + text[at + len(number.group()):]).encode()

    def test_policies_carry_the_checked_weights(self):
        kinds = {"header": (), "header of doubles": ("--precision", "double"), "onnx": (), "torchscript": ()}
        if torch_export() is None:
            kinds["pt2"] = ()
        for kind, words in kinds.items():
            with self.subTest(kind=kind):
                policy = self.path("policy")
                code, _, err = self.call("export", self.run_file, "--format", kind.split()[0], *words, "--out", policy)
                self.assertEqual(code, 0, err)
                code, out, err = self.check(self.run_file, policy)
                self.assertEqual(code, 0, out + err)
                self.assertRegex(out, r"weights in \S+ +holds")
                with open(policy, "rb") as file:
                    data = self.changed_policy(kind, file.read())
                with open(policy, "wb") as file:
                    file.write(data)
                code, out, err = self.check(self.run_file, policy)
                self.assertEqual(code, 3, out + err)
                self.assertRegex(out, r"weights in \S+ +NOT SHOWN")


if __name__ == "__main__":
    command_line.main()
