# SPDX-License-Identifier: BSD-3-Clause
"""Trains, verifies, measures and exports. What each of these changes is the run file, which it then reads again."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Union

from . import _native
from .config import Config, config_text
from .run import Run

Path = Union[str, "os.PathLike[str]"]
RunLike = Union[Run, str, "os.PathLike[str]"]  # a run, or the path of its file


@dataclass(frozen=True)
class Round:
    """What on_round hears of: the warm start (round 0) or a round of joint training and the search after it."""

    round: int
    stage: str  # search, imitation_finetune, enlarge
    loss: float
    mse: float  # of f on the demonstrations, normalised
    counterexamples: dict[str, int]  # found after it, by condition
    safe_share: float  # of the label points, those with safe rollouts
    volume: float  # of {B <= 0} as a share of the workspace, after rounds that let it grow
    seconds: float  # of training so far


OnRound = Callable[[Round], object]


def _path(run: RunLike) -> str:
    return run.path if isinstance(run, Run) else os.fspath(run)


@contextlib.contextmanager
def _torch_threads_kept() -> Iterator[None]:
    """Training sets the number of threads of the torch that it shares with Python; this sets it back."""
    torch = sys.modules.get("torch")
    before = torch.get_num_threads() if torch else None
    try:
        yield
    finally:
        if torch:
            torch.set_num_threads(before)


def _listener(on_round: OnRound | None) -> Callable[[dict[str, Any]], object] | None:
    return None if on_round is None else lambda row: on_round(Round(**row))


def train(
    config: Config,
    *,
    out: Path | None = None,
    data: Path = "",
    seed: int | None = None,
    settings: Mapping[str, Any] | None = None,
    threads: int = 0,
    on_round: OnRound | None = None,
) -> Run:
    """Trains until the networks are verified as the configuration asks, and stores the run. As `s2nnds train`.

    config    path of a TOML file, or a dict like its content
    out       run file to write; default NAME-seedN.h5
    data      folder of the data files; "": $S2NNDS_DATA, else ../shared/data
    seed, settings   override the configuration, {"training.rounds": 5}
    threads   0: all cores
    on_round  is called with a Round after the warm start and after every round

    Other Python threads run meanwhile. Ctrl-C (KeyboardInterrupt) and any exception of on_round end the training after
    the round under way; the run file then holds all rounds so far, and resume() goes on from there. Raises Error.
    """
    text = config_text(config, {**(settings or {}), **({} if seed is None else {"seed": seed})})
    path = os.fspath(out) if out is not None else f"{text.name}-seed{text.seed}.h5"
    with _torch_threads_kept():
        _native.train(text, path, os.fspath(data), threads, _listener(on_round))
    return Run(path)


def resume(
    run: RunLike, *, out: Path | None = None, threads: int = 0, on_round: OnRound | None = None
) -> Run:
    """Goes on from the last round of an interrupted training, with the same result as an unbroken one."""
    path = _path(run) if out is None else os.fspath(out)
    with _torch_threads_kept():
        _native.resume(_path(run), path, threads, _listener(on_round))
    return Run(path)


def verify(
    run: RunLike,
    method: str = "proof",
    *,
    threads: int = 0,
    samples: int | None = None,
    epsilon: float | None = None,
    beta: float | None = None,
) -> Run:
    """Checks the run's networks by `method`: sampled, conformal or proof. The certificate in its file is updated.

    samples: a region; epsilon, beta: of conformal. None: as the run's configuration says.
    """
    with _torch_threads_kept():
        _native.verify(_path(run), method, threads, samples, epsilon, beta)
    return Run(_path(run))


def evaluate(run: RunLike, *, threads: int = 0) -> Run:
    """Measures errors and safe areas of the run's motion anew, in its file."""
    with _torch_threads_kept():
        _native.evaluate(_path(run), threads)
    return Run(_path(run))


def export(run: RunLike, out: Path | None = None, *, format: str = "header", precision: str = "float") -> str:
    """Writes the policy as a file and returns its path. Formats as `s2nnds export --help` lists them.

    precision is that of f in a C++ header: float or double.
    """
    os.environ.setdefault("S2NNDS_PYTHON", sys.executable)  # what writes the formats that torch itself has to write
    endings = dict(_native.export_endings())
    path = os.path.splitext(_path(run))[0] + endings.get(format, "") if out is None else os.fspath(out)
    _native.export_policy(_path(run), format, precision, path)
    return path
