// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

// How far points can be moved, whichever way, before they leave {B < 0} inside the workspace. Sound in
// floating point.
class LevelDistance {
 public:
  // Covers {B = 0} by narrow boxes. The functions must outlive this.
  LevelDistance(const ProofFunctions& functions, const SafetyProblem& problem);

  // Of points [N, n] -> [N], all >= 0: B < 0 wherever |y - x|_2 < distance, y in the workspace, and the ball
  // lies in it. 0 where that is not certain of x itself.
  Vector below(const Points& x) const;

 private:
  Vector inside(const Points& x) const;

  const ProofFunctions& functions_;
  Box workspace_;
  bool complete_ = false;
  std::vector<Box> cover_;  // {B = 0} lies in their union
};

}  // namespace s2nnds
