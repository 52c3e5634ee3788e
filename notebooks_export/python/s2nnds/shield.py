# SPDX-License-Identifier: BSD-3-Clause
"""What keeps any wanted velocity in the safe set of a run; NumPy alone. Run.shield() calls it, the exported C++ header
computes the same, and s2nnds/verification/README.md says why it holds."""

import numpy as np


def _length(vectors):
    return np.sqrt(np.sum(vectors * vectors, axis=1))


def _drawn_into_cone(off, gradient, cone):
    """The vectors off [N, n] that are not in the circular cone off . gradient + cone |off| <= 0, projected on it.

    Returns them and whether each was outside. gradient [N, n]; cone is a number >= 0. With the room for rounding of the header.
    """
    size = _length(gradient)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = cone * (1.0 + 1e-6) / size + 1e-9
        along = -np.sum(gradient * off, axis=1)
        distance = np.sum(off * off, axis=1)
        outside = ~(along >= cosine * size * np.sqrt(distance))
        along = along / size
        across = np.sqrt(np.maximum(0.0, distance - along**2))
        sine = np.sqrt(np.maximum(0.0, 1.0 - cosine**2))
        length = cosine * along + sine * across
        axis = -gradient / size[:, None]
        edge = cosine[:, None] * axis + (sine / across)[:, None] * (off - along[:, None] * axis)
        projected = np.where(((cosine < 1.0) & (length > 0.0) & (across > 0.0))[:, None], length[:, None] * edge, 0.0)
    return np.where(outside[:, None], projected, off), outside


def shield(run, position, wanted):
    """(v, change): the velocities v [N, n] that replace wanted [N, n] at the readings position [N, n], and |v - wanted| [N].

    All in the data's unit and frame (per second); single points [n] give [n] and a number. v keeps a robot that moves as the
    run's execution model says, and starts in the safe set, in it: shortened to most_command, and near the set's edge projected
    on the velocities that lead away from it as certainly as the motion's own. Where wanted is not finite, v is the motion's
    own, and where position is not, 0; both give an infinite change. Raises ValueError where nothing of it is certified.
    """
    execution = run.certificate["execution"]
    if run.guarantee != "invariant" or not execution.get("invariant") or not execution.get("shielded"):
        raise ValueError(
            "shield: found a run without a certified shield, expected one verified for a [execution] small enough "
            "(s2nnds verify RUN --method proof --set execution.KEY=VALUE)"
        )
    position, wanted = np.asarray(position, dtype=float), np.asarray(wanted, dtype=float)
    if position.shape != wanted.shape or position.ndim not in (1, 2) or position.shape[-1] != run.dimension:
        raise ValueError(
            f"shield: found positions {list(position.shape)} and velocities {list(wanted.shape)}, "
            f"expected both [N, {run.dimension}] or [{run.dimension}]"
        )
    single = position.ndim == 1
    x, wanted = np.atleast_2d(position), np.atleast_2d(wanted)
    with np.errstate(invalid="ignore", over="ignore"):
        own = execution["speed"] * run.velocity(x)
        known, usable = np.isfinite(np.sum(own * own, axis=1)), np.isfinite(np.sum(wanted * wanted, axis=1))
    v = np.where(known[:, None], own, 0.0)
    change = np.full(len(x), np.inf)
    at = np.flatnonzero(known & usable)
    if at.size:
        v[at], change[at] = _shielded(run, x[at], wanted[at], own[at])
    return (v[0], change[0]) if single else (v, change)


def _shielded(run, x, wanted, own):
    """shield() of finite readings and wishes."""
    execution, data = run.certificate["execution"], run.data
    most = data.velocity_scale * execution["most_command"]
    size = _length(wanted)
    share = np.where(size > most, most / np.maximum(size, most) * (1.0 - 1e-15), 1.0)
    v = share[:, None] * wanted
    z = data.to_normalized(x)
    inside = np.all((z >= run.problem.workspace_lower) & (z <= run.problem.workspace_upper), axis=1)
    deep = run.B(z) < -(execution["shield_band"] + run.certificate["barrier_float64_error"])
    near = np.flatnonzero(~(inside & deep))
    changed = share < 1.0
    if near.size:
        off, outside = _drawn_into_cone(v[near] - own[near], run.B.gradient(z[near]), execution["shield_cone"])
        room = np.maximum(0.0, most**2 - np.sum(own[near] ** 2, axis=1))
        square, mixed = np.sum(off * off, axis=1), np.sum(off * own[near], axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (np.sqrt(mixed**2 + square * room) - mixed) / square * (1.0 - 1e-12)
        kept = np.where(square + 2.0 * mixed > room, np.clip(reach, 0.0, 1.0), 1.0)
        v[near[outside]] = (own[near] + kept[:, None] * off)[outside]
        changed[near] |= outside
    return v, np.where(changed, _length(v - wanted), 0.0)
