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
  // What is wanted of |B - c| on X0, of B - c on Xu, and of -Bdot where |B - c| <= 1.5 level_band, each >= 0: only
  // safest() asks for more than the slacks.
  double margin_initial = 0.05, margin_unsafe = 0.05, margin_decrease = 0.05;
};

// Which level set of B to call {B = 0}. The conditions on B speak of one level set only, and what training
// has made of B may violate them there, but hold, or hold for a larger set, at a level nearby.
class LevelChoice {
 public:
  LevelChoice(const SafetyProblem& problem, const LevelOptions& options);  // copies what it needs of them

  // The largest c in [-reach, reach] such that no sample violates a condition of B - c, with the slack; none
  // if there is no such c. Samples only: whoever shifts B must look again.
  std::optional<double> largest(const Networks& networks, RandomStream& random) const;

  // The c in [-reach, reach] at which the least margin, each as a share of what is wanted and 1 at most, is largest; the
  // largest such c. None if no c leaves the slack on X0 and Xu. For many dimensions, where samples miss the worst points,
  // so that a level with no more than the slack is violated somewhere.
  std::optional<double> safest(const Networks& networks, RandomStream& random) const;

 private:
  // B and Bdot at samples.
  struct Look {
    double most_initial, least_outside;  // B on X0; on Xu and the workspace margin
    double low, high;                    // c that leaves the slack there
    Vector value, derivative;            // B and Bdot at those points of X where B is near to a c
  };
  // None if low > high, or if B overflows.
  std::optional<Look> look(const Networks& networks, RandomStream& random) const;

  Box workspace_;
  LevelOptions options_;
  std::optional<RegionSampler> initial_;
  std::vector<RegionSampler> outside_;  // Xu and the workspace margin
};

}  // namespace s2nnds
