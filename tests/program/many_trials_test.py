#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two thousand trials of one sweep, each a shell script that writes a result: what is measured is the sweep itself."""

import os
import time

import command_line
from command_line import ProgramTest
from sweep_test import sweep_text

# As a trial leaves it, with the numbers of a real one.
STUB = """#!/bin/sh
while [ $# -gt 1 ]; do case $1 in --out) out=$2;; --trial) trial=$2;; esac; shift; done
file=$out/runs/$(printf '%04d/%07d' $((trial / 1000)) $trial).json
[ $((trial % 500)) -eq 7 ] && exit 5
printf '{"trial":%d,"status":"done","error":"","guarantee":"none","seconds":0.001,"metrics":{"mse_train":1.3077975383418998,"mse_validation":0.%04d1,"safe_area":2.15625,"rounds":2,"seconds_training":0.158156727}}\\n' $trial $trial > $file.partial
mv $file.partial $file
"""
TRIALS = 2000


class ManyTrialsTest(ProgramTest):
    def test_two_thousand(self):
        with open(self.path("stub"), "w", encoding="utf-8") as file:
            file.write(STUB)
        os.chmod(self.path("stub"), 0o755)
        with open(self.path("sweep.toml"), "w", encoding="utf-8") as file:
            file.write(sweep_text('"training.loss.decay_rate" = { log_range = [0.01, 1.0] }', design='"sobol"', points="1000"))
        words = ("sweep", self.path("sweep.toml"), "--out", self.path("out"), "--program", self.path("stub"))
        began = time.monotonic()
        code, out, err = self.call(*words)
        seconds = time.monotonic() - began
        self.assertEqual(code, 0, err[-2000:])
        self.assertIn(f"{TRIALS} trials ended, 4 of them failed, 0 missing", out)
        self.assertEqual(err.count("ended with exit code 5 and no result"), 4)
        with open(self.path("out/table.csv"), encoding="utf-8") as file:
            self.assertEqual(len(file.readlines()), TRIALS + 1)
        began = time.monotonic()
        self.assertEqual(self.call(*words)[0], 0)
        again = time.monotonic() - began
        files = [os.path.join(folder, name) for folder, _, names in os.walk(self.path("out")) for name in names]
        sizes = [os.path.getsize(name) for name in files]
        print(
            f"{TRIALS} trials in {seconds:.1f} s, {1e3 * seconds / TRIALS:.2f} ms each, the stub's own time included; "
            f"reading and ranking all results {again:.2f} s; {len(sizes)} files, {sum(sizes) / 1e6:.1f} MB"
        )
        self.assertLess(seconds, 120)
        self.assertLess(again, 10)


if __name__ == "__main__":
    command_line.main()
