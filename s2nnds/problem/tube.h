// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/region.h"

namespace s2nnds {

// All points within `radius` of the segment from `start` to `end`, both [n]; level: the signed distance.
// Throws Error unless all is finite and radius > 0.
RegionPtr capsule(const Vector& start, const Vector& end, double radius);
// The solid cylinder in 3-D whose flat ends are centred at `start` and `end`; level: the signed distance.
// Throws Error unless all is finite, the two differ, and radius > 0.
RegionPtr cylinder(const Vector& start, const Vector& end, double radius);

}  // namespace s2nnds
