// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/training/counterexample.h"

namespace s2nnds {

// Looks for Bdot >= 0 at uniform points of the band |B| <= eps_B, of which uniform points of a workspace of many
// dimensions hit few.
class BandFalsifier : public CounterexampleSource {
 public:
  explicit BandFalsifier(std::int64_t samples) : samples_(samples) {}  // points of the band, >= 1
  bool only_when_clean() const override { return true; }
  Counterexamples find(const Networks& networks, const SafetyProblem& problem, double level_band,
                       std::uint64_t seed, std::int64_t round) override;

 private:
  std::int64_t samples_;
};

}  // namespace s2nnds
