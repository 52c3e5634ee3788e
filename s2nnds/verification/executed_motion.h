// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/conditions/execution_model.h"
#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

// What is certified of the motion as a robot executes it, for every speed factor of the model (a constant one
// where lag > 0). All in normalised length and time.
struct ExecutedMotion {
  // {B <= 0} is invariant: grad B . xdot < 0 wherever B = 0, whatever the model allows (given that the
  // proof's guarantee is `invariant`).
  bool invariant = false;
  // Such motions converge to the ball |x|_2 <= convergence_radius: outside of a sublevel set of V in it,
  // grad V . xdot < 0. Infinite if that cannot be shown.
  double convergence_radius = 0.0;
  double most_command = 0.0;  // above |speed f| at every reading, in {B <= 0} or off by position_error
  std::int64_t boxes = 0;     // examined
  double seconds = 0.0;       // wall clock
  std::string reason = {};    // why nothing was examined, where that is so
};

// Decides it by branch and bound; sound in floating point. False and infinite where it cannot be shown.
// Throws Error on a model outside of the ranges that it names, or one whose dimension differs.
ExecutedMotion prove_executed(const ProofFunctions& functions, const SafetyProblem& problem,
                              const ExecutionModel& model);

// Whether {B <= 0} is invariant for motions as executed, as prove_executed says; at most `kept_boxes` boxes
// where that stays open come back.
BranchResult prove_executed_invariance(const ProofFunctions& functions, const SafetyProblem& problem,
                                       const ExecutionModel& model, std::int64_t kept_boxes);

// Speed factors for which {B <= 0} is certified to be invariant: all from `least` to `most`, proved interval
// by interval. Both are 0 if the model's own speed is not certified. `least` is 0 where arbitrarily slow
// motions are certified, `most` is infinite where nothing grows with the speed.
struct SpeedRange {
  double least = 0.0, most = 0.0;
  double most_command = 0.0;  // above |most f| at every reading; 0 where `most` is infinite
};
SpeedRange certified_speeds(const ProofFunctions& functions, const SafetyProblem& problem,
                            const ExecutionModel& model);

// What a filter of velocities needs to keep {B <= 0} invariant under the model, whatever velocity is wanted:
// near {B = 0} it admits the velocities v with
//   grad B(y) . (v - speed f(y)) + cone |v - speed f(y)| <= 0 at the reading y, |v| <= most_command.
// Then grad B(x) . v <= grad B(x) . speed f(y) at each x with B(x) = 0 that may be read as y.
struct Shield {
  bool certified = false;
  double band = 0.0;          // B(y) >= -band for every reading y of a place where B = 0
  double cone = 0.0;          // above |grad B(x) - grad B(y)|_2 for these
  double most_command = 0.0;  // above |speed f| at every reading
};
// As prove_executed for arbitrary velocities up to most_command; never certified with lag > 0.
Shield prove_shield(const ProofFunctions& functions, const SafetyProblem& problem,
                    const ExecutionModel& model);

}  // namespace s2nnds
