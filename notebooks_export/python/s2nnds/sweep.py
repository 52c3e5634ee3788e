# SPDX-License-Identifier: BSD-3-Clause
"""Reads the table of a sweep (table.h5 in its folder). Needs numpy and h5py.

    from s2nnds import Sweep
    sweep = Sweep("recipe-sweep/table.h5")
    sweep["mse_validation"], sweep["training.loss.decay_rate"]    # one array a column, one entry a trial
    sweep.axes, sweep.objective, sweep.ranking()
    sweep.effects["mse_validation"]    # Effect(kind, trials, change, error): what each axis does by itself, one entry a row
    sweep.effect_rows                  # (axis, from, to) of these entries
"""

import os
from collections import namedtuple

import h5py
import numpy as np

Effect = namedtuple("Effect", "kind trials change error")  # kind: factor or difference; error: the standard error of change


class SweepError(Exception):
    """The table cannot be used; one line that says why."""


class Sweep:
    def __init__(self, path):
        self.folder = os.path.dirname(os.path.abspath(path))
        try:
            with h5py.File(path, "r") as file:
                for name in ("name", "objective", "direction", "guarantee", "dtw_limit", "share"):
                    setattr(self, name, file.attrs[name])
                self.axes = [str(name) for name in file.attrs["axes"]]
                self.names = [str(name) for name in file.attrs["columns"]]
                self._axis = {name: dict(file["trials"][name].attrs) for name in self.axes}  # scale, values
                self._columns = {name: self._column(file["trials"][name]) for name in self.names}
        except (OSError, KeyError) as error:
            raise SweepError(f"{path}: not the table of a sweep: {str(error).splitlines()[0]}") from error
        steps = [(axis, str(values[0]), str(end)) for axis in self.axes for values in [self._axis[axis]["values"]] for end in values[1:]]
        self.effect_rows = steps
        names = dict.fromkeys([self.objective, "counts", "safe_area_ratio", "seconds"])
        found = {name: self._effect(name) for name in names if name in self}
        self.effects = {name: effect for name, effect in found.items() if effect is not None}

    @staticmethod
    def _column(item):
        return np.array(item.asstr()[()], dtype=object) if item.dtype.kind == "O" else item[()]

    def _position(self, step):
        """[trials] where the step's column of the linear model has each trial: in [0, 1] along a range, 0 or 1 of a list."""
        axis, start, end = step
        if self._axis[axis]["scale"] == "list":
            column = self[axis]
            return (column == (end if column.dtype.kind == "O" else float(end))).astype(float)
        scaled = np.log if self._axis[axis]["scale"] == "log" else np.asarray
        low, high = scaled(float(start)), scaled(float(end))
        return (scaled(self[axis]) - low) / (high - low)

    def _effect(self, name):
        """What each step does to a figure, all other axes as they are: least squares over the last rung's trials, figure
        (or its logarithm, of positive figures) = a constant of the problem + for each axis a slope over its range, or a
        constant of each value of its list. "counts" is of all trials, the others are of those that count. The errors
        assume that what the model leaves out is independent from trial to trial. None: these trials do not tell."""
        used = (self["rung"] == self["rung"].max()) & (self["status"] != "missing")
        used &= np.isfinite(self[name]) & (self.reached() | (name == "counts"))
        value = self[name][used]
        factor = name not in ("counts", "safe_area_ratio") and bool(np.all(value > 0))
        value = np.log(value) if factor else value
        problems = [self["config"][used] == problem for problem in sorted(set(self["config"][used]))]
        columns = [self._position(step)[used] for step in self.effect_rows] + problems
        if not self.effect_rows or len(value) <= len(columns) or np.ptp(value) == 0:
            return None
        model = np.stack(columns, axis=1).astype(float)
        if np.linalg.matrix_rank(model) < len(columns):
            return None
        q, r = np.linalg.qr(model)
        root = np.linalg.inv(r)
        solution = root @ (q.T @ value)
        deviation = np.sqrt(np.sum((value - model @ solution) ** 2) / (len(value) - len(columns)))
        change, error = solution, deviation * np.linalg.norm(root, axis=1)
        rounding = 1e-12 * np.abs(value).max()  # all that is left where the figure is the same in each problem's trials
        change, error = (np.where(np.abs(x) < rounding, 0.0, x)[: len(self.effect_rows)] for x in (change, error))
        if factor:
            change = np.exp(change)
            error = change * error
        return Effect("factor" if factor else "difference", len(value), change, error)

    def __getitem__(self, name):
        return self._columns[name]

    def __contains__(self, name):
        return name in self._columns

    def __len__(self):
        return len(self["trial"])

    def run(self, trial):
        """The path of a trial's run file, for Run."""
        (row,) = np.flatnonzero(self["trial"] == trial)
        return os.path.join(self.folder, self["run"][row])

    def done(self):
        """[trials] those that ended without an error."""
        return self["status"] == "done"

    def reached(self):
        """[trials] those with the sweep's guarantee, by a motion within its dtw_limit."""
        return self["counts"] == 1.0

    def ranking(self):
        """(point, share that counts, objective) of the last rung's points, as the program ranks them."""
        last = self["rung"] == self["rung"].max()
        rows = []
        for point in np.unique(self["point"][last]):
            of_point = last & (self["point"] == point)
            values = self[self.objective][of_point & self.done()] if self.objective in self else np.zeros(0)
            values = values[np.isfinite(values)]
            if len(values) == 0:
                value = np.nan
            elif np.all(values > 0):
                value = float(np.exp(np.mean(np.log(values))))
            else:
                value = float(np.mean(values))
            rows.append((int(point), float(np.mean(self.reached()[of_point])), value))
        sign = -1.0 if self.direction == "maximize" else 1.0

        def badness(row):
            _, share, value = row
            feasible = share >= self.share and np.isfinite(value)
            cost = sign * value if np.isfinite(value) else np.inf
            return (not feasible, 0.0 if feasible else -share, cost)

        return sorted(rows, key=badness)


def pareto_front(cost, gain):
    """Indices of the points that no other one beats in both (less cost, less gain: both are minimised), by cost."""
    order = np.lexsort((gain, cost))
    best, front = np.inf, []
    for index in order:
        if np.isfinite(cost[index]) and gain[index] < best:
            best = gain[index]
            front.append(index)
    return np.array(front, dtype=int)
