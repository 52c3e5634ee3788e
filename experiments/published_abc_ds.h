#pragma once

#include <string>
#include <vector>

#include "s2nnds/problem/polynomial.h"
#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds::experiment {

// A published result of ABC-DS: polynomials of two coordinates, normalised by the largest norms.
struct PublishedAbcDs {
  std::vector<Polynomial> f, V, B;  // 2, 1, 1

  Points velocity(const Points& x) const;  // f, [N, 2]
  // The motion from `start` at each of `times` (ascending, from 0): [M, 2], Dormand-Prince (Boost.Odeint).
  Points roll_out_at(const Vector& start, const Vector& times) const;
  double safe_area() const;  // of {B <= 0} within [-1, 1]^2
  // Of the starts in [-1, 1]^2 from which f reaches the goal without leaving the square or meeting the unsafe
  // set, on a grid of 100 x 100 cells; classical Runge-Kutta with a fixed step.
  double true_safe_area(const SafetyProblem& problem) const;
};

// From DATA/abc_ds/MOTION_result.json. Linear terms of V below 1e-12, which the solver left, are dropped: by
// them V < 0 somewhere arbitrarily near the goal. Throws Error if the file cannot be read.
PublishedAbcDs read_published_abc_ds(const std::string& motion, const std::string& data);

// What the prover says of them on their own workspace [-1, 1]^2 and with the sets of `problem`: V > 0 and
// Vdot < 0 but at the goal, B <= 0 on X0, B > 0 on the unsafe set, Bdot < 0 where B = 0.
ProofResult judge(const PublishedAbcDs& published, SafetyProblem problem);

}  // namespace s2nnds::experiment
