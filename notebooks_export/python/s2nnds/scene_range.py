# SPDX-License-Identifier: BSD-3-Clause
"""The motion of a certified run for every displacement of an obstacle in a range; NumPy alone, but for the range itself,
which the program finds. Run.scene_range() makes it; the exported C++ header (export --range) computes the same, and
s2nnds/verification/README.md says why it holds."""

import json
import os
import subprocess

import numpy as np

SLOPE, RAMP = 4.0 / 3.0, 0.25  # of the smooth step (problem/displacement.h)


class SceneRange:
    """Positions x [N, n] and displacements p [places] in the data's unit and frame; T_p(y) = y + p psi(y)."""

    def __init__(self, run, found):
        self.run = run
        self.statement = found["statement"]
        self.radius = found["radius"]  # |p| <= radius, and
        self.half_sizes = np.array(found["half_sizes"])  # |p_i| <= half_sizes_i, where there are some
        self.center = np.array(found["center"])
        self.inner, self.outer = found["inner"], found["outer"]
        self.margin = found["margin"]  # certified for x' = velocity(x, p) + w, |w| <= this
        self.stretch = found["stretch"]

    def holds(self, p):
        """Whether the displacement p [places] is certified."""
        p = np.asarray(p, dtype=float)
        fits = self.half_sizes.size == 0 or bool(np.all(np.abs(p) <= self.half_sizes))
        return p.shape == self.center.shape and fits and bool(np.linalg.norm(p) <= self.radius)

    def after(self, y, p):
        """T_p(y): where what was at y is seen in the displaced scene."""
        y, p = np.array(y, dtype=float), self._certified(p)
        y[..., : p.size] += self._bump(y)[..., None] * p
        return y

    def before(self, x, p):
        """T_p^-1(x)."""
        x, p = np.array(x, dtype=float), self._certified(p)
        return x - self._share(x, p)[..., None] * self._padded(p, x)

    def velocity(self, x, p, rate=None):
        """[N, n] in the data's unit per second, where the obstacle is displaced by p and moves with the velocity `rate`."""
        p, y = self._certified(p), self.before(x, p)
        v = self.run.velocity(y)
        off = y[..., : p.size] - self.center
        v = v + (self._slope(y) * np.sum(off * v[..., : p.size], axis=-1))[..., None] * self._padded(p, v)
        if rate is not None:
            v = v + self._bump(y)[..., None] * self._padded(np.asarray(rate, dtype=float), v)
        return v

    def lyapunov(self, x, p):
        """V_p: [N], or a number for a single point."""
        return self.run.lyapunov(self.before(x, p))

    def barrier(self, x, p):
        """B_p, <= 0 in the displaced safe set: [N], or a number for a single point. The header's `safe` leaves room for
        rounding."""
        return self.run.barrier(self.before(x, p))

    def _certified(self, p):
        if not self.holds(p):
            raise ValueError(f"scene range: found the displacement {p}, expected {self.center.size} numbers, at most "
                             f"{self.radius:.4g} long" + (f" and within {self.half_sizes}" if self.half_sizes.size else ""))
        return np.asarray(p, dtype=float)

    @staticmethod
    def _padded(p, x):
        """p as a change of states, which have a phase, too."""
        return np.append(p, np.zeros(x.shape[-1] - p.size))

    def _distance(self, x):
        return np.linalg.norm(x[..., : self.center.size] - self.center, axis=-1)

    def _bump(self, x):
        """psi(x)."""
        t = np.clip((self.outer - self._distance(x)) / (self.outer - self.inner), 0.0, 1.0)
        edge = np.minimum(t, 1.0 - t)
        u = edge / RAMP
        rise = SLOPE * np.where(edge < RAMP, RAMP * u**3 * (1.0 - 0.5 * u), edge - 0.5 * RAMP)
        return np.where(t > 0.5, 1.0 - rise, rise)

    def _slope(self, x):
        """What the gradient of psi is times (x - center)."""
        distance, width = self._distance(x), self.outer - self.inner
        t = np.clip((self.outer - distance) / width, 0.0, 1.0)
        u = np.minimum(1.0, np.minimum(t, 1.0 - t) / RAMP)
        return -SLOPE * u * u * (3.0 - 2.0 * u) / (width * np.maximum(distance, np.finfo(float).tiny))

    def _share(self, x, p):
        """s = psi(x - s p), by Newton's method kept in an interval."""
        low, high, s = np.zeros(x.shape[:-1]), np.ones(x.shape[:-1]), self._bump(x)
        for _ in range(60):
            y = x - s[..., None] * self._padded(p, x)
            excess = s - self._bump(y)
            low, high = np.where(excess <= 0.0, s, low), np.where(excess > 0.0, s, high)
            newton = s - excess / (1.0 + self._slope(y) * np.sum((y[..., : p.size] - self.center) * p, axis=-1))
            step = np.where((newton > low) & (newton < high), newton, 0.5 * (low + high))
            step = np.where(np.abs(excess) <= 2e-16, s, step)
            if np.array_equal(step, s, equal_nan=True):
                break
            s = step
        return s


def find_scene_range(run, obstacle, stretch, within, program):
    """Run.scene_range()."""
    program = program or os.path.join(os.path.dirname(os.path.abspath(__file__)), "s2nnds")
    if not os.path.exists(program):
        raise OSError(f"scene_range: found no program {program}, expected a build or an installed wheel")
    words = [program, "range", run.path, "--obstacle", str(obstacle), "--stretch", str(stretch), "--json"]
    if within is not None:
        words += ["--within", *map(str, np.atleast_1d(within))]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        raise ValueError(done.stderr.strip())
    return SceneRange(run, json.loads(done.stdout.splitlines()[-1])["range"])
