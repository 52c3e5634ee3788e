// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "s2nnds/problem/region.h"

namespace s2nnds {

// {(x, s) in R^(n+1): x in the region of R^n, from <= s <= to}: what does not depend on the last coordinate. Its level
// is the greatest of region.level(x), from - s and s - to, so that it is 1-Lipschitz where the region's is. Sound
// whatever the region: a box is seen without its last side. Throws Error unless from <= to; both may be infinite.
RegionPtr extruded(RegionPtr region, double from = -std::numeric_limits<double>::infinity(),
                   double to = std::numeric_limits<double>::infinity());

}  // namespace s2nnds
