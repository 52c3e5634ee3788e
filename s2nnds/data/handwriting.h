// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// Synthetic handwriting shipped inside: a smooth planar or spatial path p(s) ending at the origin, traversed
// with minimum-jerk timing s = 10 u^3 - 15 u^4 + 6 u^5, u = t / duration (Flash and Hogan 1985), so that the
// motion starts and ends at rest. Seven demonstrations of 1000 samples over 4 to 6 s: each has its own
// duration (standard deviation 4 %) and adds to the path a smooth random deviation, about 5 % of the motion's
// size at the start and zero at the goal. Velocities are exact derivatives. Fixed seed: the data set is the
// same everywhere. Unit: mm, about the size of the LASA motions. Paths keep clear of themselves, so that a
// law xdot = f(x) can describe them. Throws Error for a motion that handwriting_motions() does not name.
DemonstrationSet handwriting(const std::string& motion);

std::vector<std::string> handwriting_motions();  // Sine, S, C, N, Spiral, Helix (the last one 3-D)

}  // namespace s2nnds
