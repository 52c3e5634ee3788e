"""Reads the table of a sweep (table.h5 in its folder). Needs numpy and h5py.

    from s2nnds_sweep import Sweep
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
                effects = file["effects"]
                texts = [effects[name].asstr()[()] for name in ("axis", "from", "to")]
                self.effect_rows = [tuple(map(str, row)) for row in zip(*texts)]
                self.effects = {str(name): self._effect(effects, name) for name in effects.attrs["figures"]}
                self._columns = {name: self._column(file["trials"][name]) for name in self.names}
        except (OSError, KeyError) as error:
            raise SweepError(f"{path}: not the table of a sweep: {str(error).splitlines()[0]}") from error

    @staticmethod
    def _column(item):
        return np.array(item.asstr()[()], dtype=object) if item.dtype.kind == "O" else item[()]

    @staticmethod
    def _effect(effects, name):
        item = effects[name]
        return Effect(str(item.attrs["kind"]), int(item.attrs["trials"]), item[()], effects[f"{name}_error"][()])

    def __getitem__(self, name):
        return self._columns[name]

    def __contains__(self, name):
        return name in self._columns

    def __len__(self):
        return len(self["trial"])

    def run(self, trial):
        """The path of a trial's run file, for s2nnds_run.Run."""
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
