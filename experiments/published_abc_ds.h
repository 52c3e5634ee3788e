// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/evaluation/state_function.h"
#include "s2nnds/problem/polynomial.h"
#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds::experiment {

// A published result of ABC-DS: polynomials of two coordinates, normalised by the largest norms.
struct PublishedAbcDs {
  std::vector<Polynomial> f, V, B;  // 2, 1, 1
};

// Polynomials as evaluation takes them, [N, n] -> [N, outputs].
StateFunction state_function(const std::vector<Polynomial>& outputs);

// The problem on the workspace [-1, 1]^2 of ABC-DS, outside of which nothing is claimed. Some initial balls
// leave it by a little: that is not judged.
SafetyProblem on_unit_square(SafetyProblem problem);

// From DATA/abc_ds/MOTION_result.json. Linear terms of V below 1e-12, which the solver left, are dropped: by
// them V < 0 somewhere arbitrarily near the goal. Throws Error if the file cannot be read.
PublishedAbcDs read_published_abc_ds(const std::string& motion, const std::string& data);

// What the prover says of them on [-1, 1]^2 with the sets of `problem`: V > 0 and Vdot < 0 but at the goal,
// B <= 0 on X0, B > 0 on the unsafe set, Bdot < 0 where B = 0.
ProofResult judge(const PublishedAbcDs& published, const SafetyProblem& problem);

}  // namespace s2nnds::experiment
