# SPDX-License-Identifier: BSD-3-Clause
from ._native import Error as Error
from .problem import Problem as Problem, demonstrations as demonstrations
from .run import Run as Run, RunError as RunError
from .sweep import Sweep as Sweep, SweepError as SweepError
from .training import (
    Round as Round,
    evaluate as evaluate,
    export as export,
    resume as resume,
    train as train,
    verify as verify,
)
