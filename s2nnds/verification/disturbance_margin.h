#pragma once

#include <cstdint>

#include "s2nnds/networks/network_weights.h"
#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

struct DisturbanceOptions {
  double tolerance = 0.03;           // relative width of the last bisection
  std::int64_t max_boxes = 500000;   // examined in each step, at most
  double resolution = 1e-4;          // boxes this small, relative to the workspace, are given up
  double radius_resolution = 0.004;  // the same for the ball around the goal
  double max_seconds = 60.0;

  void visit(FieldVisitor& v);
};

struct DisturbanceMargin {
  // For every w(t) with |w|_2 <= margin, grad B . (f + w) < 0 wherever B = 0, so xdot = f(x) + w keeps {B <=
  // 0} invariant (given that the proof's guarantee is `invariant`). 0: nothing is certified. Normalised
  // velocity.
  double margin = 0.0;
  // Motions under such w that start in {B <= 0} converge to the ball |x|_2 <= convergence_radius: outside of
  // a sublevel set of V within it, Vdot + |grad V| margin < 0. Infinite if that cannot be shown. Normalised
  // position.
  double convergence_radius = 0.0;
  std::int64_t boxes = 0;
  double seconds = 0.0;
};

// The largest disturbance that the barrier provably withstands, by bisection. Sound in floating point.
DisturbanceMargin disturbance_margin(const ProofFunctions& functions, const SafetyProblem& problem,
                                     const DisturbanceOptions& options = {});

// Whether {B <= 0} withstands every |w|_2 <= disturbance (>= 0): grad B . f + disturbance |grad B|_2 < 0
// wherever B = 0. At most `kept_boxes` boxes where that stays open come back.
BranchResult prove_under_disturbance(const ProofFunctions& functions, const SafetyProblem& problem,
                                     double disturbance, std::int64_t kept_boxes,
                                     const DisturbanceOptions& options = {});

// The radius of the ball that motions under |w|_2 <= disturbance converge to while they stay in {B <= 0}.
double convergence_radius(const ProofFunctions& functions, const SafetyProblem& problem, double disturbance,
                          const DisturbanceOptions& options = {});

// A bound on |y_float32(x) - y(x)|_2 over the box: every product and sum of the layers rounded to 24 bits in
// any order, weights, biases and x rounded to float32 first, up to two more roundings of x and y (scales),
// and activations wrong by at most 8 units in the last place (of 1, for bounded ones). The offset N(0) of an
// zero_at_origin network counts twice. Rigorous for values below 1e30, with gradual underflow.
double float32_error(const NetworkWeights& network, const Box& box);

}  // namespace s2nnds
