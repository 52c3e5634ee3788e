// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/region.h"

namespace s2nnds {

// The normalised positions z whose place in the data's frame, x = goal + scale z, lies in the region, exactly;
// level(z) = region.level(x) / scale. Sound whatever the region: its enclosure is that of the box of all x,
// rounded outwards. describe() tells the region as it was written, in the data's frame. Throws Error unless
// goal [n] is finite and scale is finite and > 0.
RegionPtr framed(RegionPtr region, const Vector& goal, double scale);

}  // namespace s2nnds
