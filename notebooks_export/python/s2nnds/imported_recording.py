# SPDX-License-Identifier: BSD-3-Clause
"""What the readers of `s2nnds import` return, and how they refuse."""

import importlib
import sys
from dataclasses import dataclass, field

import numpy as np


class ImportRefused(Exception):
    """One line: what was found and what was expected."""


@dataclass
class Recording:
    """One demonstration as its source has it."""

    source: str  # the file or folder
    time: np.ndarray  # [M] s, from any start
    position: np.ndarray  # [M, n], in `unit`
    coordinates: list  # n names
    unit: str = ""  # m, rad; "" when the source does not say
    frame: str = ""  # of the positions: "map"
    velocity: np.ndarray | None = None  # [M, n]
    orientation: np.ndarray | None = None  # [M, 4], x y z w
    origin: dict = field(default_factory=dict)  # more about where it came from: attribute -> text or number


def package(name, what):
    """The optional package, imported now. Raises ImportRefused where it is missing."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        distribution = name.split(".")[0]
        raise ImportRefused(
            f"{what} needs the Python package {distribution}, which {sys.executable} does not have ({error}); "
            f"pip install {distribution}, or name another Python in S2NNDS_PYTHON"
        ) from None
