// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/perturbation.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

// The ball around the goal that motions xdot = f(x) + delta converge to.
struct ConvergenceBall {
  // Outside of a sublevel set of V whose part in {B <= 0} lies in |x|_2 <= radius, grad V . (f + delta) < 0 in
  // {B <= 0}. Infinite if that cannot be shown, or only for a ball that is as wide as the workspace.
  double radius = 0.0;
  std::int64_t boxes = 0;  // examined
};

// Sound in floating point; the caller's thread must compute as StandardFloatingPoint says.
ConvergenceBall convergence_ball(const ProofFunctions& functions, const SafetyProblem& problem,
                                 const PerturbationFactory& perturbation, BranchLimits limits);

}  // namespace s2nnds
