// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/training/counterexample.h"

namespace s2nnds {

// Looks for Bdot >= 0 on the band |B| <= eps_B, which few uniform points of a workspace of many dimensions hit: points
// are moved onto it along the gradient of B, and the worst of them climb on it (climb.h). Half of the points are uniform
// in the workspace; half are such points shrunk towards the goal, around which hardly any lie in many dimensions.
class BandFalsifier : public CounterexampleSource {
 public:
  // `samples` points are moved, >= 1; `near` as for climb().
  BandFalsifier(std::int64_t samples, double near) : samples_(samples), near_(near) {}
  Counterexamples find(const Networks& networks, const SafetyProblem& problem, double level_band,
                       std::uint64_t seed, std::int64_t round) override;

 private:
  std::int64_t samples_;
  double near_;
};

}  // namespace s2nnds
