// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

// How large a disturbance w of the motion, xdot = f(x) + w, is certified to do no harm.
struct DisturbanceMargin {
  // For every w(t) with |w|_2 <= margin, grad B . (f + w) < 0 wherever B = 0, so xdot = f(x) + w keeps
  // {B <= 0} invariant (given that the proof's guarantee is `invariant`). 0: nothing is certified. Normalised
  // velocity.
  double margin = 0.0;
  // Motions under such w that start in {B <= 0} converge to the ball |x|_2 <= convergence_radius: outside of
  // a sublevel set of V within it, Vdot + |grad V| margin < 0. Infinite if that cannot be shown. Normalised
  // position.
  double convergence_radius = 0.0;
  std::int64_t boxes = 0;  // examined, of all steps
  double seconds = 0.0;    // wall clock
};

// Below, functions whose underflow is not covered (ProofFunctions::beyond_range) withstand nothing.

// The largest disturbance that the barrier provably withstands, by bisection. Sound in floating point.
DisturbanceMargin disturbance_margin(const ProofFunctions& functions, const SafetyProblem& problem);

// The radius of the ball that motions under |w|_2 <= disturbance converge to while they stay in {B <= 0}.
double convergence_radius(const ProofFunctions& functions, const SafetyProblem& problem, double disturbance);

}  // namespace s2nnds
