// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/data/frame.h"
#include "s2nnds/evaluation/rollout.h"
#include "s2nnds/networks/orientation_law.h"

namespace s2nnds {

// How far the orientations of motions are from those of the demonstrations, rad; NaN without demonstrations.
struct OrientationErrors {
  double mean = 0.0;     // over the matched pairs of each demonstration, then over the demonstrations
  double largest = 0.0;  // of all pairs
};

// Motions from the first pose of each demonstration (normalised), at its times. The two courses of orientations are
// matched by dynamic time warping with the angle between two of them as its cost.
OrientationErrors orientation_errors(const StateFunction& f, const OrientationLaw& law, const Frame& frame,
                                     const std::vector<Demonstration>& demonstrations,
                                     const RolloutOptions& options = {});

// The angles between the rows of `a` and `b` [N, 4] by pairs that dynamic time warping matches.
Vector matched_angles(const Points& a, const Points& b);

}  // namespace s2nnds
