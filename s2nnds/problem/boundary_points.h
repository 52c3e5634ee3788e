// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/core/random.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {

// Points on the boundary of a region, with the unit normals that point out of it.
struct BoundaryPoints {
  // The points, one a row: [count, n]
  Points point, normal;  // the normal at each point: [count, n], of length 1
};

// At most `count` points of the boundary inside the box, where segments from uniform points of the region to
// uniform points of the box leave it: not uniform on the boundary. None where the level has no slope.
BoundaryPoints boundary_points(const RegionPtr& region, const Box& within, std::int64_t count,
                               RandomStream& random);

}  // namespace s2nnds
