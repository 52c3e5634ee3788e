// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "s2nnds/sweeps/sweep.h"
#include "s2nnds/sweeps/trial_result.h"

namespace s2nnds {

// How good a point is, by all its trials of one rung.
struct PointScore {
  std::int64_t point = 0;   // of Sweep::points, from 0
  std::int64_t trials = 0;  // with a result
  std::int64_t failed = 0;  // of these, failed
  double share = 0.0;       // of the trials that should be there, those that count; in [0, 1]
  bool feasible = false;    // share is at least the wanted one, and the objective was measured
  // Geometric mean over the trials, whose problems differ in scale; the arithmetic one when a value is not
  // positive; NaN when nothing was measured.
  double objective = 0.0;
};

// Whether the result has the sweep's guarantee, by a motion that goes the demonstrations' way (dtw_limit).
bool counts(const SweepOptions& options, const TrialResult& result);

// Best first: feasible points by the objective, then the others by their share and by the objective.
// `results` are of one rung.
std::vector<PointScore> rank_points(const Sweep& sweep, const std::vector<TrialResult>& results);

// The points of the rung after one that had `count` points, by that rung's ranking, in ascending order.
std::vector<std::int64_t> promoted(const HalvingOptions& options, const std::vector<PointScore>& ranking);

}  // namespace s2nnds
