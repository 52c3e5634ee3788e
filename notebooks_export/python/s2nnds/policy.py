# SPDX-License-Identifier: BSD-3-Clause
"""A run's policy as a torch.nn.Module. Needs torch; Run.policy() makes one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

if TYPE_CHECKING:
    from .run import Run


class Policy(torch.nn.Module):
    """Velocities of positions, in the data's unit and frame. What an exported TorchScript module answers.

    policy(x)                                             [N, n] -> [N, n]
    policy.safe(x), policy.barrier(x), policy.lyapunov(x) [N]
    policy.unit, .frame_name, .goal, .workspace           of the positions: as in every export, with the scales
    policy.guarantee, .statement, .weight_hash, .position_scale, .velocity_scale

    Computes in double and answers in the precision of x. Its parameters are copies: training them further ends what the
    certificate says.
    """

    def __init__(self, run: Run) -> None:
        super().__init__()
        self.f, self.V, self.B = run.f.torch(), run.V.torch(), run.B.torch()
        self.unit: str = run.data.unit
        self.frame_name: str = run.data.frame_name
        self.unsafe_set: str = run.problem.unsafe
        self.guarantee: str = run.guarantee
        self.statement: str = run.certificate.get("statement", "")
        self.weight_hash: str = run.certificate.get("weight_hash", "")
        self.dimension: int = run.dimension
        self.phase_start: float = run.phase_start
        self.position_scale: float = run.data.position_scale
        self.velocity_scale: float = run.data.velocity_scale
        self.barrier_error: float = run.certificate.get("barrier_float64_error", 0.0)
        self.register_buffer("goal", torch.tensor(run.data.goal))
        self.register_buffer("workspace_lower", torch.tensor(run.data.to_data(run.problem.workspace_lower)))
        self.register_buffer("workspace_upper", torch.tensor(run.data.to_data(run.problem.workspace_upper)))

    @property
    def workspace(self) -> list[float]:
        """[2 n]: lower corner, upper corner."""
        return self.workspace_lower.tolist() + self.workspace_upper.tolist()

    def _normalised(self, x: torch.Tensor) -> torch.Tensor:
        return (x.to(self.goal.dtype) - self.goal) / self.position_scale

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return (self.velocity_scale * self.f(self._normalised(x))).to(x.dtype)

    def lyapunov(self, x: torch.Tensor) -> torch.Tensor:
        return self.V(self._normalised(x)).to(x.dtype)

    def barrier(self, x: torch.Tensor) -> torch.Tensor:
        return self.B(self._normalised(x)).to(x.dtype)

    def safe(self, x: torch.Tensor) -> torch.Tensor:
        """[N] whether x lies in the safe set: B <= 0 by more than rounding, within the workspace."""
        y = x.to(self.workspace_lower.dtype)
        inside = (y >= self.workspace_lower) & (y <= self.workspace_upper)
        return (self.B(self._normalised(x)) <= -self.barrier_error) & inside.all(1)
