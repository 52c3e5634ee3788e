// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "s2nnds/conditions/condition.h"
#include "s2nnds/conditions/execution_model.h"
#include "s2nnds/core/random.h"
#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {

// Options of LevelChoice. All but `samples` are in the unit of B.
struct LevelOptions {
  // Uniform in X, >= 1; two fifths as many each in X0, Xu and the workspace margin.
  std::int64_t samples = 25000;
  double level_band = 0.01;        // eps_B > 0
  double reach = 0.1;              // |c| at most, >= 0
  double slack = 0.005;            // B differs from c by at least this on X0 and Xu, >= 0
  double slack_decrease = 0.03;    // where |B - c| <= 1.5 level_band, Bdot <= -slack_decrease; >= 0
  ExecutionDemand execution = {};  // whose Bdot that is
};

// Which level set of B to call {B = 0}. The conditions on B speak of one level set only, and what training
// has made of B may violate them there, but hold, or hold for a larger set, at a level nearby.
class LevelChoice {
 public:
  LevelChoice(const SafetyProblem& problem, const LevelOptions& options);  // copies what it needs of them

  // The largest c in [-reach, reach] such that no sample violates a condition of B - c, with the slack; none
  // if there is no such c. Samples only: whoever shifts B must look again.
  std::optional<double> largest(const Networks& networks, RandomStream& random) const;

 private:
  Box workspace_;
  LevelOptions options_;
  std::optional<RegionSampler> initial_;
  std::vector<RegionSampler> outside_;  // Xu and the workspace margin
};

}  // namespace s2nnds
