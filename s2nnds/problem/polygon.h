// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/problem/region.h"

namespace s2nnds {

// The polygon with these corners [V, 2], in either direction and not closed by a repeated first one, without
// the inside of the holes, whose edges belong to it. Level: the signed distance. Throws Error unless every
// ring has three corners or more, no edge has length 0 and no two edges cross or touch.
RegionPtr polygon(const Points& corners, const std::vector<Points>& holes = {});

}  // namespace s2nnds
