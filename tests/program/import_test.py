#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""`s2nnds import`: recordings written by the packages' own writers, read back, and damaged ones."""

import os
import subprocess
import sys
import unittest

import command_line
import h5py
import numpy as np
from command_line import PROJECT, ProgramTest

try:
    import mcap.writer
    import rosbags.rosbag1
    import rosbags.rosbag2
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore
except ImportError as error:
    ROS_MISSING = f"{sys.executable}: {error}; pip install rosbags mcap"
else:
    ROS_MISSING = ""
try:
    import pyarrow
    import pyarrow.parquet
except ImportError as error:
    PARQUET_MISSING = f"{sys.executable}: {error}; pip install pyarrow"
else:
    PARQUET_MISSING = ""

START = 1_700_000_000_123_456_789  # ns
STEP = 20_000_000
M = 40


def positions(k=0):
    s = np.linspace(0, 1, M)
    return np.column_stack([0.1 + s, 0.5 - s**2 + 0.01 * k, 0.3 * s])


class Messages:
    """Messages of ROS 1 or 2, of the kinds that are read."""

    def __init__(self, ros):
        self.ros = ros
        self.store = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_HUMBLE)
        tf = "tf2_msgs/msg/TFMessage"
        if tf not in self.store.types:
            self.store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", tf))

    def make(self, name, *values):
        return self.store.types[name](*values)

    def header(self, i, frame):
        time = self.make("builtin_interfaces/msg/Time", *divmod(START + i * STEP, 10**9))
        return self.make("std_msgs/msg/Header", *((i,) if self.ros == 1 else ()), time, frame)

    def of(self, kind, i, k=0):
        x = positions(k)[i]
        point = self.make("geometry_msgs/msg/Point", *x)
        turned = self.make("geometry_msgs/msg/Quaternion", *((-1) ** i * np.array([0.0, 0.0, np.sin(0.1 * i), np.cos(0.1 * i)])))
        pose = self.make("geometry_msgs/msg/Pose", point, turned)
        transform = self.make(
            "geometry_msgs/msg/TransformStamped",
            self.header(i, "world"),
            "tool",
            self.make("geometry_msgs/msg/Transform", self.make("geometry_msgs/msg/Vector3", *x), turned),
        )
        joints = ["a", "b", "c"] if i % 2 == 0 else ["c", "a", "b"]  # in any order
        by_name = dict(zip("abc", x))
        values = np.array([by_name[name] for name in joints])
        return {
            "geometry_msgs/msg/Pose": lambda: pose,
            "geometry_msgs/msg/PoseStamped": lambda: self.make(kind, self.header(i, "base"), pose),
            "geometry_msgs/msg/TransformStamped": lambda: transform,
            "tf2_msgs/msg/TFMessage": lambda: self.make(kind, [transform]),
            "sensor_msgs/msg/JointState": lambda: self.make(kind, self.header(i, ""), joints, values, 2 * values, np.empty(0)),
            "std_msgs/msg/Float64MultiArray": lambda: self.make(kind, self.make("std_msgs/msg/MultiArrayLayout", [], 0), x),
        }[kind]()


def write_bag(path, ros, topics, samples=M):
    """A ROS 1 bag, or the folder of a ROS 2 one."""
    messages = Messages(ros)
    writer = rosbags.rosbag1.Writer(path) if ros == 1 else rosbags.rosbag2.Writer(path, version=8)
    with writer as bag:
        for topic, kind in topics.items():
            connection = bag.add_connection(topic, kind, typestore=messages.store)
            for i in range(samples):
                message = messages.of(kind, i)
                data = (messages.store.serialize_ros1 if ros == 1 else messages.store.serialize_cdr)(message, kind)
                bag.write(connection, START + i * STEP + 5_000_000, data)


def write_mcap(path, topic, kind):
    messages = Messages(2)
    with open(path, "wb") as file:
        writer = mcap.writer.Writer(file)
        writer.start(profile="ros2")
        text = messages.store.generate_msgdef(kind, ros_version=2)[0].encode()
        channel = writer.register_channel(topic, "cdr", writer.register_schema(kind, "ros2msg", text))
        for i in range(M):
            data = bytes(messages.store.serialize_cdr(messages.of(kind, i), kind))
            writer.add_message(channel, START + i * STEP, data, START + i * STEP)
        writer.finish()


class ImportTest(ProgramTest):
    def imported(self, *words):
        code, out, err = self.call("import", *words, "--out", "d.h5")
        self.assertEqual((code, err), (0, ""), out)
        with h5py.File(self.path("d.h5")) as file:
            group = file["demonstrations"]
            items = [({key: item[()] for key, item in one.items()}, dict(one.attrs)) for one in group.values()]
            return out, dict(group.attrs), items

    def assert_is_the_motion(self, values, columns=(0, 1, 2)):
        np.testing.assert_allclose(values["time"], STEP * 1e-9 * np.arange(M), atol=1e-12)
        np.testing.assert_allclose(values["position"], positions()[:, columns])


class RefusalTest(ImportTest):
    def test_what_is_no_recording_is_refused(self):
        os.mkdir(self.path("empty"))
        for words, *expected in (
            (("none.bag",), "none.bag", "no such file"),
            (("empty",), "empty", "LeRobot", "ROS 2"),
            ((), "sources"),
        ):
            self.assert_refused(self.call("import", *words, "--out", "d.h5"), *expected)
        self.assertFalse(os.path.exists(self.path("d.h5")))

    def test_a_missing_package_is_named(self):
        with open(self.path("d.bag"), "wb") as file:
            file.write(b"#ROSBAG V2.0\n")
        os.mkdir(self.path("without"))
        for name in ("rosbags", "mcap", "pyarrow"):
            with open(self.path(f"without/{name}.py"), "w", encoding="utf-8") as file:
                file.write("raise ImportError('left out')\n")
        variables = {"PYTHONPATH": self.path("without")}
        # The program puts its own package first, then what was there.
        result = self.call("import", "d.bag", "--out", "d.h5", variables=variables)
        self.assert_refused(result, "rosbags", "pip install rosbags", "S2NNDS_PYTHON")


@unittest.skipIf(ROS_MISSING, ROS_MISSING)
class RosTest(ImportTest):
    def test_every_kind_of_message(self):
        for ros in (1, 2):
            for kind in (
                "geometry_msgs/msg/Pose",
                "geometry_msgs/msg/PoseStamped",
                "geometry_msgs/msg/TransformStamped",
                "sensor_msgs/msg/JointState",
                "std_msgs/msg/Float64MultiArray",
            ):
                with self.subTest(ros=ros, kind=kind):
                    name = f"{kind.split('/')[-1]}{ros}" + (".bag" if ros == 1 else "")
                    write_bag(self.path(name), ros, {"/moved": kind})
                    out, about, [(values, origin)] = self.imported(name)
                    self.assert_is_the_motion(values)
                    self.assertEqual(about["unit"], {"JointState": "rad", "Float64MultiArray": ""}.get(kind.split("/")[-1], "m"))
                    self.assertEqual(origin["topic"], "/moved")
                    self.assertIn(name, origin["source"])
                    self.assertEqual(len(origin["sha256"]), 64)
                    if kind.endswith("JointState"):
                        np.testing.assert_allclose(values["velocity"], 2 * positions())
                        self.assertEqual(list(about["coordinates"]), ["a", "b", "c"])
                    if kind.endswith("Stamped"):
                        self.assertEqual(about["frame"], "world" if "Transform" in kind else "base")
                        self.assertIn("headers", origin["times"])
                    if "orientation" in values:  # written with both signs
                        self.assertGreater(np.sum(values["orientation"][1:] * values["orientation"][:-1], axis=1).min(), 0.9)

    def test_a_lone_mcap_file(self):
        write_mcap(self.path("d.mcap"), "/pose", "geometry_msgs/msg/PoseStamped")
        _, about, [(values, _)] = self.imported("d.mcap")
        self.assert_is_the_motion(values)
        self.assertEqual((about["unit"], about["frame"]), ("m", "base"))

    def test_several_files_topics_frames_and_coordinates(self):
        topics = {"/pose": "geometry_msgs/msg/PoseStamped", "/tf": "tf2_msgs/msg/TFMessage"}
        for name in ("a.bag", "b.bag"):
            write_bag(self.path(name), 1, topics)
        self.assert_refused(self.call("import", "a.bag", "--out", "d.h5"), "--topic", "/pose", "/tf")
        self.assert_refused(self.call("import", "a.bag", "--topic", "/none", "--out", "d.h5"), "/none", "/pose")
        self.assert_refused(self.call("import", "a.bag", "--topic", "/tf", "--out", "d.h5"), "--child", "tool")
        _, about, items = self.imported("a.bag", "b.bag", "--topic", "/tf", "--child", "tool", "--coordinates", "x", "2")
        self.assertEqual((len(items), list(about["coordinates"])), (2, ["x", "z"]))
        for values, _ in items:
            self.assert_is_the_motion(values, (0, 2))
        _, _, [(values, origin)] = self.imported("a.bag", "--topic", "/pose", "--time", "received")
        self.assertIn("receipt", origin["times"])
        # Pauses begin other demonstrations: here every step is one.
        self.assert_refused(
            self.call("import", "a.bag", "--topic", "/pose", "--gap", "0.001", "--out", "e.h5"), "no demonstration"
        )

    def test_damaged_files_are_refused(self):
        write_bag(self.path("a.bag"), 1, {"/pose": "geometry_msgs/msg/Pose"})
        write_mcap(self.path("a.mcap"), "/pose", "geometry_msgs/msg/PoseStamped")
        write_bag(self.path("two"), 2, {"/pose": "geometry_msgs/msg/Pose"}, samples=1)
        self.assert_refused(self.call("import", "two", "--out", "d.h5"), "1 message")
        for name in ("a.bag", "a.mcap"):
            with open(self.path(name), "rb") as file:
                whole = file.read()
            for share in (0.0, 0.3, 0.7, 0.99):
                cut = f"cut{name[1:]}"
                with open(self.path(cut), "wb") as file:
                    file.write(whole[: int(share * len(whole))])
                self.assert_refused(self.call("import", cut, "--out", "d.h5"), cut)
        self.assertFalse(os.path.exists(self.path("d.h5")))


@unittest.skipIf(PARQUET_MISSING, PARQUET_MISSING)
class LeRobotTest(ImportTest):
    def test_episodes_and_columns(self):
        script = os.path.join(PROJECT, "experiments/walkthroughs/make_recordings.py")
        subprocess.run([sys.executable, script, "lerobot", self.path("set")], check=True)
        out, about, items = self.imported("set")
        self.assertEqual((len(items), list(about["coordinates"]), about["unit"]), (6, ["x", "y"], ""))
        self.assertIn("without gripper", out)
        _, _, items = self.imported("set", "--episodes", "4", "2", "--coordinates", "y", "x")
        self.assertEqual([origin["episode"] for _, origin in items], [4, 2])
        self.assertEqual(len(items[0][0]["time"]), len(items[0][0]["position"]))
        self.assert_refused(self.call("import", "set", "--episodes", "9", "--out", "e.h5"), "episode 9")
        self.assert_refused(self.call("import", "set", "--column", "action", "--out", "e.h5"), "action", "observation.state")
        table = self.path("set/data/chunk-000/file-000.parquet")
        with open(table, "rb") as file:
            whole = file.read()
        with open(table, "wb") as file:
            file.write(whole[: len(whole) // 2])
        self.assert_refused(self.call("import", "set", "--out", "e.h5"), "file-000.parquet")
        with open(self.path("set/meta/info.json"), "w", encoding="utf-8") as file:
            file.write("{")
        self.assert_refused(self.call("import", "set", "--out", "e.h5"), "info.json")


if __name__ == "__main__":
    command_line.main()
