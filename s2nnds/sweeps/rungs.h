#pragma once

#include <cstdint>
#include <vector>

#include "s2nnds/sweeps/ranking.h"
#include "s2nnds/sweeps/sweep_folder.h"

namespace s2nnds {

// The results of those of `trials` that have one.
std::vector<TrialResult> read_results(const SweepFolder& folder, const std::vector<std::int64_t>& trials);

// The trials of the points, in ascending order.
std::vector<std::int64_t> trials_of(const Sweep& sweep, std::int64_t rung,
                                    const std::vector<std::int64_t>& points);

// How far a sweep has come, from what its folder holds.
struct SweepState {
  std::int64_t rung = 0;              // the first one that is not complete, or the last one
  std::vector<std::int64_t> trials;   // of that rung
  std::vector<std::int64_t> missing;  // those of them that have no result
  std::vector<TrialResult> results;   // of all rungs up to that one
  std::vector<TrialResult> of_rung;   // of that rung
  bool complete() const { return missing.empty(); }
};
SweepState read_state(const Sweep& sweep, const SweepFolder& folder);

}  // namespace s2nnds
