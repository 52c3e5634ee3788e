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
    policy.shield(x, v_wanted)                            [N, n] -> [N, n], [N]: safe velocities, and how far they
                                                          are from those wanted; needs a run whose shield is certified
    policy.guarantee, policy.weight_hash, policy.position_scale, policy.velocity_scale

    Computes in double and answers in the precision of x. Its parameters are copies: training them further ends what the
    certificate says.
    """

    def __init__(self, run: Run) -> None:
        super().__init__()
        self.f, self.V, self.B = run.f.torch(), run.V.torch(), run.B.torch()
        self.guarantee: str = run.guarantee
        self.weight_hash: str = run.certificate.get("weight_hash", "")
        self.dimension: int = run.dimension
        self.position_scale: float = run.data.position_scale
        self.velocity_scale: float = run.data.velocity_scale
        self.execution: dict = run.certificate.get("execution", {})
        self.barrier_error: float = run.certificate.get("barrier_float64_error", 0.0)
        self.register_buffer("goal", torch.tensor(run.data.goal))
        self.register_buffer("workspace_lower", torch.tensor(run.data.to_data(run.problem.workspace_lower)))
        self.register_buffer("workspace_upper", torch.tensor(run.data.to_data(run.problem.workspace_upper)))

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

    def shield(self, x: torch.Tensor, v_wanted: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """What the exported header's shield(x, v_wanted, v) answers: v [N, n] and |v - v_wanted| [N]."""
        if self.guarantee != "invariant" or not self.execution.get("shielded", 0):
            raise ValueError("shield: found a run without a certified shield, expected one verified with [execution]")
        fastest = self.velocity_scale * self.execution["most_command"]
        z = self._normalised(x).detach().requires_grad_(True)
        barrier = self.B(z)
        (gradient,) = torch.autograd.grad(barrier.sum(), z)
        with torch.no_grad():
            own = self.execution["speed"] * self.velocity_scale * self.f(z)
            wanted = v_wanted.to(own.dtype)
            finite = wanted.isfinite().all(1, keepdim=True)
            speed = wanted.norm(dim=1, keepdim=True)
            v = torch.where(speed > fastest, wanted * (fastest / speed) * (1 - 1e-15), wanted)
            off = v - own
            size, distance = gradient.norm(dim=1, keepdim=True), off.norm(dim=1, keepdim=True)
            axis = -gradient / size
            cosine = self.execution["shield_cone"] * (1 + 1e-6) / size + 1e-9
            along = (axis * off).sum(1, keepdim=True)
            side = off - along * axis
            across = side.norm(dim=1, keepdim=True)
            sine = (1 - cosine**2).clamp(min=0).sqrt()
            length = cosine * along + sine * across
            some = (cosine < 1) & (length > 0) & (across > 0)
            nearest = torch.where(some, length * (cosine * axis + sine * side / across), torch.zeros_like(off))
            square, mixed = (nearest**2).sum(1, keepdim=True), (nearest * own).sum(1, keepdim=True)
            room = (fastest**2 - (own**2).sum(1, keepdim=True)).clamp(min=0)
            kept = ((((mixed**2 + square * room).sqrt() - mixed) / square).clamp(0, 1)) * (1 - 1e-12)
            kept = torch.where(square + 2 * mixed > room, kept, torch.ones_like(kept))
            near = ~(barrier.unsqueeze(1) < -(self.execution["shield_band"] + self.barrier_error))
            v = torch.where(near & ~(along >= cosine * distance), own + kept * nearest, v)
            change = (v - wanted).norm(dim=1)
            v = torch.where(finite, v, own)
            change = torch.where(finite[:, 0], change, torch.full_like(change, torch.inf))
            lost = ~own.isfinite().all(1, keepdim=True)
            v = torch.where(lost, torch.zeros_like(v), v)
            change = torch.where(lost[:, 0], torch.full_like(change, torch.inf), change)
        return v.to(x.dtype), change.to(x.dtype)
