// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// The demonstrations with velocities (1 - share) v + share g(x), 0 <= share <= 1: g is a PhaseRegression of
// all of them, so what one demonstration does otherwise than its neighbours counts less. The share falls to 0
// where they spread from 0.15 to 0.3 about their mean (standard deviation): what they do there is no noise.
// Normalised units. Nothing changes with share 0 or one demonstration.
std::vector<Demonstration> smoothed(std::vector<Demonstration> demonstrations, double share);

}  // namespace s2nnds
