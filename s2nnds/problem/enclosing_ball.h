// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "s2nnds/problem/region.h"

namespace s2nnds {

// A ball of places.
struct EnclosingBall {
  Vector center;        // [places]
  double radius = 0.0;  // > 0
};

// A ball that holds, in its first `places` coordinates, every point that the region has within the finite box: a proof
// by `Region::classify` on boxes that cover it, with distances rounded up. Nearly the smallest in the plane, within
// some percent in more dimensions. None where the region has no point in the box, or where more than half of the box
// may belong to it. Throws Error unless 0 < places <= n.
std::optional<EnclosingBall> enclosing_ball(const Region& region, const Box& within, Eigen::Index places);

// A number that is at most the distance, in the first coordinates, from `center` [places] to any point that the region has
// within the finite box: infinite where there is none. Proved as above, and too small by 1e-4 of the box's longest side
// where 100,000 boxes suffice for that.
double distance_below(const Region& region, const Box& within, const Vector& center);

}  // namespace s2nnds
