// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/problem/region.h"

namespace s2nnds {

// All points of the grid with these coordinates on its axes, each evenly spaced and at least one, with the last axis
// running fastest: [product of the sizes, n].
Points grid_points(const std::vector<Vector>& axes);

// The region's level at these points, for figures, which draw where it changes its sign. A part of the set that falls
// between the points would not be seen: where the cell around a point holds some of it, and neither the point nor one of
// its neighbours lies in the set, the level is the least one found in the cell. Throws Error as Region::level does.
Vector grid_level(const Region& region, const std::vector<Vector>& axes);

}  // namespace s2nnds
