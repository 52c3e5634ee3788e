# SPDX-License-Identifier: BSD-3-Clause
"""What a configuration asks for, before anything is trained."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._native import PreparedRun
from .config import Config, config_text
from .run import Data, Demonstration


def _data(prepared: PreparedRun) -> Data:
    values = prepared.data
    return Data(**{**values, "demonstrations": [Demonstration(*arrays) for arrays in values["demonstrations"]]})


class Problem:
    """The demonstrations and sets of a configuration, checked: raises Error for whatever is wrong with them.

    data                                 as Run.data: demonstrations as read, and how they are normalised
    workspace_lower, workspace_upper     [n], normalised
    unsafe, initial                      the sets Xu and X0 in words
    """

    def __init__(
        self, config: Config, *, data: str | os.PathLike[str] = "", settings: Mapping[str, Any] | None = None
    ) -> None:
        self._prepared = PreparedRun(config_text(config, settings), os.fspath(data))
        self.name: str = self._prepared.name
        self.data: Data = _data(self._prepared)
        self.workspace_lower: NDArray[np.float64] = self._prepared.workspace_lower
        self.workspace_upper: NDArray[np.float64] = self._prepared.workspace_upper
        self.unsafe: str = self._prepared.unsafe
        self.initial: str = self._prepared.initial

    @property
    def dimension(self) -> int:
        return self.data.dimension

    def unsafe_level(self, x: ArrayLike) -> NDArray[np.float64]:
        """[N] of points [N, n], normalised: negative inside the unsafe set, positive outside."""
        return self._prepared.unsafe_level(np.ascontiguousarray(x, dtype=float))

    def initial_level(self, x: ArrayLike) -> NDArray[np.float64]:
        """The same of the initial set."""
        return self._prepared.initial_level(np.ascontiguousarray(x, dtype=float))


def demonstrations(
    config: Config, *, data: str | os.PathLike[str] = "", settings: Mapping[str, Any] | None = None
) -> Data:
    """The demonstrations that a configuration names, as Run.data has them. `data` is the folder of their files.

    demonstrations({"data.source": "handwriting", "data.motion": "Sine"}) needs no files.
    """
    return Problem(config, data=data, settings=settings).data
