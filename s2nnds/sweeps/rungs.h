// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "s2nnds/sweeps/ranking.h"
#include "s2nnds/sweeps/sweep_folder.h"

namespace s2nnds {

// How far a sweep has come, from what its folder holds.
struct SweepState {
  std::int64_t rung = 0;                             // the first one that is not complete, or the last one
  std::vector<std::int64_t> trials;                  // of that rung, ascending
  std::vector<std::int64_t> missing;                 // those of them that have no result
  std::vector<TrialResult> results;                  // of all rungs up to that one
  std::vector<TrialResult> of_rung;                  // of that rung
  bool complete() const { return missing.empty(); }  // every trial of the rung has a result
};

// Looks through the folder's results, rung by rung; a result that cannot be read counts as missing.
SweepState read_state(const Sweep& sweep, const SweepFolder& folder);

}  // namespace s2nnds
