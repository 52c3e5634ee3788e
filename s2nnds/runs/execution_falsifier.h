// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/conditions/execution_model.h"
#include "s2nnds/training/counterexample.h"
#include "s2nnds/verification/rounding_error.h"

namespace s2nnds {

// Asks whether {B <= 0} is invariant for motions as the robot executes them, with f evaluated in float32. Boxes where it
// stays open go back into training. To be added behind the ProofSource, whose conditions it presumes.
class ExecutionFalsifier : public CounterexampleSource {
 public:
  // `keep`: points that are handed on, at most.
  explicit ExecutionFalsifier(const ExecutionModel& model, std::int64_t keep = counterexamples_kept)
      : model_(model), keep_(keep) {}
  bool only_when_clean() const override { return true; }
  Counterexamples find(const Networks& networks, const SafetyProblem& problem, double level_band,
                       std::uint64_t seed, std::int64_t round) override;

 private:
  ExecutionModel model_;
  std::int64_t keep_;  // points that are handed on
  Float32Error field_error_;
};

}  // namespace s2nnds
