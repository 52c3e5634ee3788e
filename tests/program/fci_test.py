#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Franka's own interface draws a certified motion, on a simulated arm that speaks it over loopback.

The arm is franka-sim (PyPI), which S2NNDS_FRANKA_SIM names by the Python that has it, with the arm of robot_arm.xml; it
enforces the real robot's limits on torques and their rates. It runs in soft real time: nothing here asks for seconds."""

import json
import os
import signal
import socket
import subprocess
import time
import unittest

import command_line
from command_line import PROJECT, SINE, ProgramTest

SIMULATOR = os.environ.get("S2NNDS_FRANKA_SIM", "")
FRICTION = ["0.285", "0.4275", "0.285", "0.6175", "0.38", "0.1425", "0.285"]  # 95 % of robot_arm.xml's


def answers(port):
    with socket.socket() as probe:
        probe.settimeout(1.0)
        return probe.connect_ex(("127.0.0.1", port)) == 0


class FciTest(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.program = command_line.driver("fci_drawing")
        if not os.path.exists(cls.program):
            raise unittest.SkipTest("fci_drawing was not built: found no libfranka")
        if not SIMULATOR:
            raise unittest.SkipTest("S2NNDS_FRANKA_SIM names no Python that has franka-sim")
        cls.file = os.path.join(cls.store, "Sine.h5")
        code, _, err = command_line.call("train", SINE, "--out", cls.file, "--until", "certified", cwd=cls.store)
        assert code == 0, err

    def setUp(self):
        super().setUp()
        environment = {**os.environ, "FR3_MJCF": os.path.join(PROJECT, "experiments/robot_arm.xml")}
        self.log = open(self.path("server.log"), "w+", encoding="utf-8")
        self.server = subprocess.Popen([SIMULATOR, "-m", "franka_sim.run_server", "--no-gripper"], env=environment,
                                       stdout=self.log, stderr=subprocess.STDOUT)
        for _ in range(120):
            if answers(1337) or self.server.poll() is not None:
                break
            time.sleep(0.5)

    def tearDown(self):
        self.server.send_signal(signal.SIGINT)
        try:
            self.server.wait(30)
        except subprocess.TimeoutExpired:
            self.server.kill()
        self.log.close()
        super().tearDown()

    def test_it_draws_the_motion_within_the_interface_s_limits(self):
        out = self.path("drawn")
        words = [self.file, "127.0.0.1", "--ready", "--soft-real-time", "--out", out, "--coulomb", *FRICTION]
        done = subprocess.run([self.program, *words], capture_output=True, text=True, check=False, timeout=1500,
                              env=command_line.environment())
        with open(self.path("server.log"), encoding="utf-8") as log:
            self.assertEqual(done.returncode, 0, done.stderr + done.stdout + log.read()[-2000:])
        with open(os.path.join(out, "robot_drawing.json"), encoding="utf-8") as file:
            (run,) = json.load(file)["motions"]
        (motion,) = run["motions"]
        self.assertTrue(motion["arrived"])
        self.assertFalse(motion["left"])
        self.assertGreater(os.path.getsize(os.path.join(out, "Sine.png")), 10000)

    def test_a_drawing_beyond_the_arm_is_refused(self):
        words = [self.file, "127.0.0.1", "--soft-real-time", "--size", "0.5", "--out", self.path("far")]
        done = subprocess.run([self.program, *words], capture_output=True, text=True, check=False, timeout=600)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("does not reach", done.stderr)


if __name__ == "__main__":
    command_line.main()
