// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/region.h"

namespace s2nnds {

// How far a set of points stays away from a region.
struct Clearance {
  // The least distance; 0 where a point lies inside; infinity where the region has no point in the box.
  double distance = 0;
  // [n] the point of the region that is nearest, [n] the one of the points; empty at infinity.
  Vector in_region, at;
  Eigen::Index inside = 0;  // how many of the points lie in the region
};

// Of points [N, n], N > 0, from the part of the region within a finite box. The distance is no larger than the
// true one, and smaller by `tolerance` > 0 at most, unless 200,000 boxes (10,000 in more than three
// dimensions) do not decide so much.
Clearance clearance(const Region& region, const Points& points, const Box& within, double tolerance);

}  // namespace s2nnds
