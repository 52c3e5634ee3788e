// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/networks/orientation_law.h"
#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

// What was shown of an orientation law on {B <= 0}.
struct OrientationBound {
  bool proved = false;     // |psi(p)| + initial_error < pi for every p of the workspace with B(p) <= 0
  double bound = 0.0;      // rad: |psi| is below it there; 0: nothing was shown
  std::int64_t boxes = 0;  // examined
  std::string reason;      // why it was not proved; "" if it was
  double seconds = 0.0;    // wall clock
};

// Proves the law's bound by Taylor models of B and psi over boxes, every rounding covered: first for bounds little above
// the largest |psi| at drawn points, then for pi - initial_error. With the position in {B <= 0} for ever, |r| <=
// |psi| + exp(-k t) |e(0)| < pi then holds for ever: the rotation vector is smooth along the motion, and the law's
// solution is the orientation.
OrientationBound prove_orientation_bound(const OrientationLaw& law, const ProofFunctions& functions,
                                         const SafetyProblem& problem, const BranchLimits& limits);

}  // namespace s2nnds
