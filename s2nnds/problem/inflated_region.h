// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/region.h"

namespace s2nnds {

// A region that holds every point within `radius` of the given one. Where the level is 1-Lipschitz, it is the
// level less the radius: exactly the points within the radius where the level is the distance outside, and
// more around corners where it is less than that (intersections, polytopes, ellipsoids, box_region). Else, for
// polynomials and expressions, it is the least level that may occur within the radius, by enclosures of small
// boxes: more than the points within the radius, by about a fifth of it. Throws Error unless 0 < radius.
RegionPtr inflated(RegionPtr region, double radius);

}  // namespace s2nnds
