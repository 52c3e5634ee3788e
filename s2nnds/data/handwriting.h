#pragma once

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// Synthetic handwriting shipped inside: a smooth planar or spatial path ending at the origin, traversed with
// minimum-jerk timing (s = 10 u^3 - 15 u^4 + 6 u^5), seven demonstrations with smooth random deviations of start and
// shape. Fixed seed: the data set is the same everywhere. Unit: mm, about the size of the LASA motions.
DemonstrationSet handwriting(const std::string& motion);  // Sine, S, C, N, Spiral, Helix (3-D)
std::vector<std::string> handwriting_motions();

}  // namespace s2nnds
