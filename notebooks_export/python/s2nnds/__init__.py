# SPDX-License-Identifier: BSD-3-Clause
"""Learns robot motions from demonstrations with a machine-checked certificate."""

import importlib

# Where each name lives. It is imported when it is first asked for: who reads a run file needs neither torch nor the
# compiled module.
_HOMES = {"Run": "run", "RunError": "run", "Sweep": "sweep", "SweepError": "sweep"}

__all__ = list(_HOMES)


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module 's2nnds' has no attribute '{name}'")
    return getattr(importlib.import_module("." + _HOMES[name], __name__), name)


def __dir__():
    return sorted([*globals(), *__all__])
