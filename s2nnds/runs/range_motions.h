// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/runs/scene_range.h"

namespace s2nnds {

// How far the motions from the training demonstrations' first points are from these (fidelity.h), where the obstacle was and
// where it is at the ends of its range (SceneRange::ends). Normalised units. A measurement, not a proof.
struct RangeMotions {
  double mean_before = 0.0;     // of the demonstrations' mean distances, the obstacle where it was
  double mean = 0.0;            // the same over all ends
  double largest_before = 0.0;  // the largest distance of a matched pair
  double largest = 0.0;         // the same over all ends
  std::int64_t motions = 0;     // followed at the ends
  std::int64_t arrived =
      0;  // of these: at the goal, without touching the displaced obstacle; all, by the proof
};

// Of the run that the range is one of.
RangeMotions motions_at_ends(const PreparedRun& setup, const RunRecord& record, const SceneRange& range);

}  // namespace s2nnds
