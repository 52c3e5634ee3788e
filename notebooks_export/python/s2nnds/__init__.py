# SPDX-License-Identifier: BSD-3-Clause
"""Learns robot motions from demonstrations, with a machine-checked certificate.

    import s2nnds
    run = s2nnds.train("reach.toml", data="FOLDER", on_round=print)   # learns, proves, stores; returns the Run
    run.guarantee, run.evaluation["mse_test"]
    run.f(x), run.V(x), run.B(x)             # x [N, n] normalised; NumPy arrays or torch tensors
    policy = run.policy()                    # a torch.nn.Module: positions in, velocities out, in the data's unit
    s2nnds.verify(run, method="proof")
    s2nnds.export(run, "reach.onnx", format="onnx")
    s2nnds.demonstrations("reach.toml", data="FOLDER"), s2nnds.Problem("reach.toml", data="FOLDER")
    s2nnds.Run("reach.h5"), s2nnds.Sweep("reach-sweep/table.h5")

Run and Sweep read files with numpy and h5py alone; the other names need the compiled module, which is there after
`pip install .` and in a build tree that had pybind11.
"""

import importlib
import importlib.util

# Where each name lives. It is imported when it is first asked for: who reads a run file needs neither torch nor the
# compiled module.
_HOMES = {
    "Problem": "problem",
    "Round": "training",
    "Run": "run",
    "RunError": "run",
    "Sweep": "sweep",
    "SweepError": "sweep",
    "Error": "_native",
    "demonstrations": "problem",
    "evaluate": "training",
    "export": "training",
    "resume": "training",
    "train": "training",
    "verify": "training",
}
_NUMPY_ALONE = ("run", "sweep")

__all__ = list(_HOMES)


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module 's2nnds' has no attribute '{name}'")
    home = _HOMES[name]
    if home not in _NUMPY_ALONE and importlib.util.find_spec(__name__ + "._native") is None:
        raise ImportError(f"s2nnds.{name} needs the compiled module: pip install . (or a build where pybind11 is)")
    return getattr(importlib.import_module("." + home, __name__), name)


def __dir__():
    return sorted([*globals(), *__all__])
