#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Damaged and doubtful recordings and obstacles of every format through the program: one line and exit code 2 before
anything is written, or, where nothing is wrong, a scene that can be looked at."""

import json
import os
import resource
import struct

import command_line
import h5py
import numpy as np
import scipy.io
from command_line import ProgramTest

KEPT = b"an older result"
M = 40  # samples of a demonstration
GOAL = (0.8, 0.3)


def motion(k=0, samples=M, seconds=2.0, dimension=2):
    """Times [M] and positions [M, n] of a reach to GOAL, in m."""
    u = np.linspace(0.0, 1.0, samples)
    s = u**3 * (10 + u * (6 * u - 15))
    columns = [0.2 + 0.6 * s, 0.3 + 0.1 * np.sin(np.pi * s) + 0.02 * k * (1 - s), 0.1 + 0.2 * s]
    return seconds * u, np.column_stack(columns[:dimension])


def table(k=0, **options):
    t, x = motion(k, **options)
    return np.column_stack([t, x])


def csv_text(rows, header="t,x,y"):
    return header + "\n" + "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows)


def matlab_cells():
    """The ds-opt cell array: positions above velocities, [2n, M] each."""
    cells = np.empty((1, 3), dtype=object)
    for k in range(3):
        t, x = motion(k)
        cells[0, k] = np.vstack([x.T, np.gradient(x, t, axis=0).T])
    return cells


def name_class(dataset, name):
    """MATLAB's attribute, as MATLAB writes texts: of fixed length, said to end with a zero."""
    kind = h5py.h5t.C_S1.copy()
    kind.set_size(len(name))
    kind.set_strpad(h5py.h5t.STR_NULLTERM)
    space = h5py.h5s.create(h5py.h5s.SCALAR)
    h5py.h5a.create(dataset.id, b"MATLAB_class", kind, space).write(np.array(name), mtype=kind)


def write_matlab_73(path):
    """The same cell array as MATLAB 7.3 has it: HDF5 behind 512 bytes, cells as references."""
    with h5py.File(path, "w", userblock_size=512) as file:
        cells = matlab_cells()
        data = file.create_dataset("data", (3, 1), dtype=h5py.ref_dtype)
        for k in range(3):
            part = file.create_dataset(f"#refs#/{'abc'[k]}", data=cells[0, k].T)
            name_class(part, b"double")
            data[k, 0] = part.ref
        name_class(data, b"cell")
        step = file.create_dataset("dt", data=np.array([[2.0 / (M - 1)]]))
        name_class(step, b"double")
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, made for a test".ljust(116) + bytes(8) + b"\x00\x02IM")


def corner_mesh():
    """A tetrahedron: its corners and its triangles, counter-clockwise seen from outside."""
    corners = 0.05 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) + np.array([0.4, 0.6, 0.2])
    return corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def write_stl(path, triangles=None):
    corners, all_of_them = corner_mesh()
    triangles = all_of_them if triangles is None else triangles
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(triangles)))
        for triangle in triangles:
            file.write(bytes(12) + np.float32(corners[list(triangle)]).tobytes() + bytes(2))


def write_obj(path, triangles=None):
    corners, all_of_them = corner_mesh()
    with open(path, "w", encoding="utf-8") as file:
        file.writelines(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in corners)
        file.writelines(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in (triangles or all_of_them))


def cloud(dimension):
    return np.array([0.4, 0.6, 0.2][:dimension]) + 0.02 * np.random.default_rng(1).uniform(-1, 1, (20, dimension))


PLY = "ply\nformat ascii 1.0\nelement vertex 20\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
PCD = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 20\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 20\nDATA ascii\n"


def write_rows(path, head=""):
    with open(path, "w", encoding="utf-8") as file:
        file.write(head + "".join(" ".join(f"{value:.6f}" for value in row) + "\n" for row in cloud(3)))


def write_map(path):
    """A room of 2 m around the motion, one cell in it occupied."""
    cells = np.full((40, 40), 254, dtype=np.uint8)
    cells[30, 8] = 0
    with open(os.path.join(os.path.dirname(path), "room.pgm"), "wb") as file:
        file.write(b"P5\n40 40\n255\n" + cells.tobytes())
    with open(path, "w", encoding="utf-8") as file:
        file.write("image: room.pgm\nresolution: 0.05\norigin: [-0.2, -0.6, 0.0]\nnegate: 0\n"
                   "occupied_thresh: 0.65\nfree_thresh: 0.196\n")  # fmt: skip


# How each format of recordings is written to a path, and the settings that read it.
RECORDINGS = {
    "csv": (lambda path: write_text(path, csv_text(table())), "csv"),
    "npy": (lambda path: np.save(path, np.stack([table(k) for k in range(3)])), "npy"),
    "npz": (lambda path: np.savez(path, time=motion()[0], position=motion()[1]), "npy"),
    "h5": (lambda path: write_hdf5(path), "hdf5"),
    "mat": (lambda path: scipy.io.savemat(path, {"data": matlab_cells(), "dt": 2.0 / (M - 1)}), "ds_opt"),
    "7.mat": (lambda path: write_matlab_73(path), "ds_opt"),
}
# Files of obstacles: how each is written, its region, the motion's dimension.
OBSTACLES = {
    "part.stl": (write_stl, 'type = "mesh", file = "part.stl"', 3),
    "part.obj": (write_obj, 'type = "mesh", file = "part.obj"', 3),
    "scan.xyz": (write_rows, 'type = "point_cloud", file = "scan.xyz", radius = 0.01', 3),
    "scan.ply": (lambda path: write_rows(path, PLY), 'type = "point_cloud", file = "scan.ply", radius = 0.01', 3),
    "scan.pcd": (lambda path: write_rows(path, PCD), 'type = "point_cloud", file = "scan.pcd", radius = 0.01', 3),
    "scan.npy": (lambda path: np.save(path, cloud(3)), 'type = "point_cloud", file = "scan.npy", radius = 0.01', 3),
    "room.yaml": (write_map, 'type = "occupancy_image", file = "room.yaml"', 2),
    "room.pgm": (lambda path: write_map(path[:-3] + "yaml"), 'type = "occupancy_image", file = "room.yaml"', 2),
}


def write_text(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def write_hdf5(path, parts=None):
    with h5py.File(path, "w") as file:
        for k, (t, x) in enumerate(parts or [motion(k) for k in range(3)]):
            file[f"demonstrations/{k}/time"] = t
            file[f"demonstrations/{k}/position"] = x


def truncate(path):
    """Cuts a file off in the middle; of text, within a line behind a separator."""
    with open(path, "rb") as file:
        whole = file.read()
    half = whole[: len(whole) // 2]
    if path.endswith(("csv", "xyz", "ply", "pcd")):
        half = half[: max(half.rfind(b","), half.rfind(b" "))]
    with open(path, "wb") as file:
        file.write(half)


class RecordingsTest(ProgramTest):
    def config(self, data, problem='unsafe = { type = "none" }'):
        write_text(self.path("my.toml"), f'name = "my"\n\n[data]\n{data}\n\n[problem]\n{problem}\n')

    def of_files(self, source, *names, more=""):
        key = f'file = "{names[0]}"' if source == "ds_opt" else f"files = {json.dumps(names)}"
        self.config(f'source = "{source}"\n{key}\n{more}')

    def assert_bad(self, *words, settings=(), preview=True):
        """`train` and `preview` are refused with one line, and what was there stays as it was. A preview that can be
        drawn takes a second."""
        flags = [word for setting in settings for word in ("--set", setting)]
        with open(self.path("run.h5"), "wb") as file:
            file.write(KEPT)
        before = sorted(os.listdir(self.folder))
        self.assert_refused(self.call("train", "my.toml", *flags, "--data", ".", "--out", "run.h5"), *words)
        self.assertEqual(sorted(os.listdir(self.folder)), before)
        with open(self.path("run.h5"), "rb") as file:
            self.assertEqual(file.read(), KEPT)
        if not preview:
            return
        code, _, err = self.call("preview", "my.toml", *flags, "--data", ".", "--out", "seen.png")
        self.assertEqual(code, 2, err)
        for word in words:
            self.assertIn(str(word), err.splitlines()[-1])

    def assert_good(self, *words, settings=()):
        """`preview` says these words and finds nothing that training would refuse; what it found, as JSON."""
        flags = [word for setting in settings for word in ("--set", setting)]
        code, out, err = self.call("preview", "my.toml", *flags, "--data", ".", "--out", "seen.png", "--json")
        self.assertEqual(code, 0, err)
        for word in words:
            self.assertIn(word, out)
        found = json.loads(out.strip().split("\n")[-1])
        self.assertEqual(found["refusals"], [])
        return found

    def csvs(self, *tables, header="t,x,y", more=""):
        for k, rows in enumerate(tables):
            write_text(self.path(f"d{k}.csv"), csv_text(rows, header))
        self.of_files("csv", *(f"d{k}.csv" for k in range(len(tables))), more=more)


class FormatsTest(RecordingsTest):
    """Every format of recordings: whole, cut off, empty, something else, not there."""

    def test_recordings(self):
        for ending, (write, source) in RECORDINGS.items():
            name = "log." + ending
            path = self.path(name)
            self.of_files(source, name)
            with self.subTest(ending=ending, file="not there"):
                self.assert_bad(name)
            with self.subTest(ending=ending, file="whole"):
                write(path)
                found = self.assert_good()
                self.assertEqual(found["dimension"], 2)
            with self.subTest(ending=ending, file="cut off"):
                truncate(path)
                self.assert_bad(name)
            with self.subTest(ending=ending, file="empty"):
                write_text(path, "")
                self.assert_bad(name)
            with self.subTest(ending=ending, file="something else"):
                write_text(path, "This is no recording at all.\nBut two lines of a letter.\n")
                self.assert_bad(name)

    def test_obstacles(self):
        for name, (write, unsafe, dimension) in OBSTACLES.items():
            header = "t,x,y,z" if dimension == 3 else "t,x,y"
            self.csvs(*(table(k, dimension=dimension) for k in range(3)), header=header)
            with open(self.path("my.toml"), encoding="utf-8") as file:
                text = file.read()
            write_text(self.path("my.toml"), text.replace('type = "none"', unsafe))
            path = self.path(name)
            with self.subTest(file=name, is_now="not there"):
                self.assert_bad("problem.unsafe", unsafe.split('"')[3], preview=False)
            with self.subTest(file=name, is_now="whole"):
                write(path)
                self.assert_good()
            with self.subTest(file=name, is_now="cut off"):
                truncate(path)
                self.assert_bad("problem.unsafe", name)
            with self.subTest(file=name, is_now="empty"):
                write_text(path, "")
                self.assert_bad("problem.unsafe", name, preview=False)
            for left in ("room.yaml", "room.pgm"):
                if os.path.exists(self.path(left)):
                    os.remove(self.path(left))

    def test_configurations(self):
        self.csvs(table())
        with open(self.path("my.toml"), encoding="utf-8") as file:
            text = file.read()
        write_text(self.path("my.toml"), text[: text.index("]\n")])
        self.assert_bad("my.toml:")
        write_text(self.path("my.toml"), "")
        self.assert_bad("my.toml", "empty file")


class NumbersTest(RecordingsTest):
    def test_nan_and_inf(self):
        for value in (np.nan, np.inf, -np.inf):
            rows = table()
            rows[7, 1] = value
            with self.subTest(value=value):
                self.csvs(rows, table(1))
                self.assert_good("0: 1 sample with missing, NaN or infinite numbers dropped")
                self.assert_bad("d0.csv:9", "NaN, infinite", settings=["data.cleaning.missing=false"])
                rows[10:30, 2] = value
                self.csvs(table(), rows)
                self.assert_bad("d1.csv", "21 of 40 samples", "20 %")
                # The same in a binary format.
                np.save(self.path("log.npy"), rows)
                self.of_files("npy", "log.npy")
                self.assert_bad("log.npy", "21 of 40 samples")
                write_hdf5(self.path("log.h5"), [(rows[:, 0], rows[:, 1:])])
                self.of_files("hdf5", "log.h5")
                self.assert_bad("log.h5: /demonstrations/0", "21 of 40 samples")

    def test_units_that_differ_between_demonstrations(self):
        in_mm = table(1) * [1, 1000, 1000]
        self.csvs(table(), in_mm)
        self.assert_bad("demonstration 0", "demonstration 1", "one unit")
        in_ms = table(1) * [1000, 1, 1]
        self.csvs(table(), in_ms)
        self.assert_bad("d1.csv", "one unit of time")

    def test_velocities_in_another_unit(self):
        t, x = motion()
        rows = np.column_stack([t, 1000 * x, np.gradient(x, t, axis=0)])
        self.csvs(rows, header="t,x,y,vx,vy", more='unit = "mm"\ntime_unit = "s"')
        self.assert_bad("demonstration 0", "recorded velocities 0.0009")

    def test_few(self):
        self.csvs(table())
        self.assertEqual(self.assert_good()["demonstrations"], 1)
        self.csvs(table()[[0, 20, -1]])
        self.assert_good()
        self.csvs(table()[[0, -1]])
        self.assert_good()
        self.csvs(table()[[0]])
        self.assert_bad("d0.csv:2", "1 sample", "at least 2")
        self.csvs(table(), table(1), more="use = [0, 5]")
        self.assert_bad("5", "expected 0 to 1")
        self.csvs(table(), table(1), more="test = [0, 1]")
        self.assert_bad("data.test", "2 of 2")

    def test_a_million_samples(self):
        """Under ten seconds of processor time, and progress."""
        rows = table(samples=10**6, seconds=100.0)
        np.save(self.path("log.npy"), rows)
        write_hdf5(self.path("log.h5"), [(rows[:, 0], rows[:, 1:])])
        np.savetxt(self.path("log.csv"), rows, fmt="%.9g", delimiter=",", header="t,x,y", comments="")
        for source, name in (("npy", "log.npy"), ("hdf5", "log.h5"), ("csv", "log.csv")):
            with self.subTest(source=source):
                self.of_files(source, name)
                used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
                code, out, err = self.call("preview", "my.toml", "--data", ".", "--out", "seen.png")
                used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - used
                self.assertEqual(code, 0, err)
                self.assertLess(used, 10.0)
                self.assertIn(f"cleaning ./{name}", err.replace("cleaning " + name, f"cleaning ./{name}"))
                self.assertIn("%", err)

    def test_columns(self):
        self.csvs(table(), more='columns = { time = "stamp" }')
        self.assert_bad("d0.csv:1", "stamp", "'t', 'x', 'y'")
        self.csvs(table(), more='columns = { position = ["x", "z"] }')
        self.assert_bad("d0.csv:1", "'z'")
        self.csvs(table(), more="columns = { position = ['7', '8'] }")
        self.assert_bad("d0.csv:1", "7")
        write_hdf5(self.path("log.h5"))
        self.of_files("hdf5", "log.h5", more='columns = { position = ["tcp"] }')
        self.assert_bad("log.h5", "/demonstrations/0/tcp")
        np.savez(self.path("log.npz"), time=motion()[0], tcp=motion()[1])
        self.of_files("npy", "log.npz")
        self.assert_bad("log.npz", "'tcp'", "data.columns.position")

    def test_matlab_variables(self):
        """Variables of any name, rows or columns; cell arrays; structure arrays."""
        t, x = motion()
        scipy.io.savemat(self.path("a.mat"), {"time": t[:, None], "position": x})
        scipy.io.savemat(self.path("b.mat"), {"t": t[None], "pos": np.float32(x.T)})
        self.of_files("mat", "a.mat", "b.mat")
        self.assertEqual(self.assert_good()["demonstrations"], 2)
        scipy.io.savemat(self.path("c.mat"), {"stamp": np.int64(1000 * t), "px": x[:, 0], "py": x[:, 1]})
        self.of_files("mat", "c.mat", more='columns = { time = "stamp", position = ["px", "py"] }\ntime_unit = "ms"')
        self.assert_good()
        self.assert_bad("c.mat", "'tcp'", "data.columns.position", settings=['data.columns.position=["tcp"]'])
        self.of_files("mat", "c.mat")
        self.assert_bad("c.mat", "'time'", "data.columns.time")
        cells = {"t": np.empty(3, dtype=object), "x": np.empty(3, dtype=object)}
        for k in range(3):
            cells["t"][k], cells["x"][k] = motion(k)
        scipy.io.savemat(self.path("d.mat"), cells)
        self.of_files("mat", "d.mat")
        self.assertEqual(self.assert_good()["demonstrations"], 3)
        members = np.array([(t, x, "note") for _ in range(2)], dtype=[("time", object), ("tcp", object), ("who", object)])
        scipy.io.savemat(self.path("e.mat"), {"demos": members})
        self.of_files("mat", "e.mat", more='columns = { index = "demos", position = ["tcp"] }')
        self.assertEqual(self.assert_good()["demonstrations"], 2)
        self.assert_bad("e.mat", "'runs'", "data.columns.index", settings=['data.columns.index="runs"'])
        self.assert_bad("e.mat: demos(1): who", settings=['data.columns.position=["who"]'])
        code, out, err = self.call("new", "a.mat", "--out", "new.toml")
        self.assertEqual(code, 0, err)
        self.assertIn("1 demonstration(s) in 2 dimensions", out)
        truncate(self.path("e.mat"))
        self.assert_bad("e.mat")
        # A published layout has all demonstrations of a motion in a file.
        os.mkdir(self.path("in"))
        scipy.io.savemat(self.path("in/f.mat"), {"data": matlab_cells(), "dt": 2.0 / (M - 1)})
        self.assertEqual(self.call("new", "in", "--out", "new.toml")[0], 0)
        scipy.io.savemat(self.path("in/g.mat"), {"data": matlab_cells(), "dt": 2.0 / (M - 1)})
        refused = self.call("new", "in", "--out", "newer.toml")
        self.assert_refused(refused, "2 MATLAB files", "f.mat", "ds-opt's", "one of them alone")

    def test_dimensions_that_differ(self):
        write_text(self.path("d0.csv"), csv_text(table()))
        write_text(self.path("d1.csv"), csv_text(table(dimension=3), "t,x,y,z"))
        self.of_files("csv", "d0.csv", "d1.csv")
        self.assert_bad("d1.csv", "3", "2")
        write_hdf5(self.path("log.h5"), [motion(), motion(dimension=3)])
        self.of_files("hdf5", "log.h5")
        self.assert_bad("log", "3", "2")
        np.save(self.path("a.npy"), table())
        np.save(self.path("b.npy"), table(dimension=3))
        self.of_files("npy", "a.npy", "b.npy")
        self.assert_bad("b.npy", "3", "2")
        self.csvs(table(dimension=3), header="t,x,y,z")
        self.assert_bad("problem.unsafe", "2", "3", settings=['problem.unsafe={type="ball", center=[0.1, 0.2], radius=0.1}'])

    def test_other_columns_beside_the_positions(self):
        """Quaternions that jump from q to -q, joints, text: left out and reported."""
        t, x = motion(dimension=3)
        q = np.column_stack([np.sin(t / 2), 0 * t, 0 * t, np.cos(t / 2)]) * np.where(np.arange(M) % 7 < 3, 1, -1)[:, None]
        rows = ["time,x,y,z,qx,qy,qz,qw,joint_1,state"]
        rows += [",".join(f"{value:.9g}" for value in (t[i], *x[i], *q[i], 0.1 * i)) + ",moving" for i in range(M)]
        write_text(self.path("d0.csv"), "\n".join(rows) + "\n")
        self.of_files("csv", "d0.csv")
        found = self.assert_good("position 'x', 'y', 'z'", "'qw'")
        self.assertEqual((found["dimension"], found["problems"]), (3, []))

    def test_time_that_goes_back(self):
        rows = table()
        rows[20:, 0] -= 1.0
        self.csvs(rows)
        self.assert_bad("d0.csv:22", "times in order")
        np.save(self.path("log.npy"), rows)
        self.of_files("npy", "log.npy")
        self.assert_bad("log.npy: sample 20", "times in order")
        rows = table()
        rows[[20, 21]] = rows[[21, 20]]
        self.csvs(rows)
        self.assert_good("1 time stamp out of order sorted")

    def test_empty_folder(self):
        os.mkdir(self.path("logs"))
        for source in ("csv", "npy", "hdf5"):
            self.of_files(source, "logs")
            self.assert_bad("logs", "files")
            self.of_files(source, "logs/d*.csv")
            self.assert_bad("logs", "d*.csv")


class SceneTest(RecordingsTest):
    def scene(self, unsafe, dimension=2):
        self.csvs(*(table(k, dimension=dimension) for k in range(3)), header="t,x,y,z"[: 2 * dimension + 1])
        with open(self.path("my.toml"), encoding="utf-8") as file:
            text = file.read()
        write_text(self.path("my.toml"), text.replace('{ type = "none" }', unsafe))

    def test_meshes(self):
        _, triangles = corner_mesh()
        write_stl(self.path("part.stl"), triangles[:3])
        self.scene('{ type = "mesh", file = "part.stl" }', 3)
        self.assert_bad("problem.unsafe", "part.stl", "3 of 6 edges are open", "closed mesh")
        write_obj(self.path("part.obj"), [*triangles[:3], triangles[3][::-1]])
        self.scene('{ type = "mesh", file = "part.obj" }', 3)
        self.assert_bad("part.obj", "turn opposite ways")
        write_obj(self.path("part.obj"), [(0, 1, 2), (0, 2, 1)])
        self.assert_bad("part.obj", "solid")

    def test_regions(self):
        for unsafe, *words in (
            ("{ type = 'polygon', vertices = [[0, 0], [1, 1], [1, 0], [0, 1]] }", "neither cross nor touch"),
            ("{ type = 'polygon', vertices = [[0, 0], [1, 1]] }", "vertices"),
            ("{ type = 'ball', center = [0.5, 0.6], radius = 0.0 }", "radius"),
            ("{ type = 'ball', center = [0.5, 0.6], radius = -0.1 }", "radius"),
            ("{ type = 'ball', center = [0.5, nan], radius = 0.1 }", "center"),
            ("{ type = 'capsule', start = [0.4, 0.6], end = [0.5, 0.6], radius = 0.0 }", "radius"),
            ("{ type = 'box', lower = [0.5, 0.6], upper = [0.4, 0.7] }", "box"),
            ("{ type = 'oriented_box', center = [0.5, 0.6], half_sizes = [0.1, 0.0] }", "half_sizes"),
            ("{ type = 'polytope', normals = [[1, 0], [-1, 0]], offsets = [0.4, -0.5] }", "polytope"),
            ("{ type = 'ball', center = [0.5, 0.6], radius = 0.1, inflate = -0.1 }", "inflate"),
            ("{ type = 'ball', center = [0.8, 0.3], radius = 0.1 }", "covers the goal", "(0.8, 0.3) m"),
            ("{ type = 'ball', center = [0.8, 0.45], radius = 0.1, inflate = 0.1 }", "covers the goal"),
            ("{ type = 'ball', center = [800, 450], radius = 100 }", "no points in the workspace"),
            ("{ type = 'ball', center = [0.2, 0.32], radius = 0.05 }", "problem.initial", "meets the unsafe set"),
            ("{ type = 'cylinder', start = [0, 0], end = [0, 1], radius = 0.1 }", "cylinder", "3"),
        ):
            with self.subTest(unsafe=unsafe):
                self.scene(unsafe)
                with open(self.path("my.toml"), encoding="utf-8") as file:
                    text = file.read()
                write_text(self.path("my.toml"), text.replace("[data]\n", '[data]\nunit = "m"\n'))
                self.assert_bad("problem", *words, preview=False)  # scene_test.py has one of each


if __name__ == "__main__":
    command_line.main()
