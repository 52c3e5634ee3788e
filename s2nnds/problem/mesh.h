// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/problem/region.h"

namespace s2nnds {

// Triangles in space.
struct TriangleMesh {
  Points vertices;            // [V, 3]
  Eigen::MatrixXi triangles;  // [T, 3], rows of `vertices`, counter-clockwise seen from outside
};

// The solid within a closed mesh: all points around which the surface winds, either way, so that shells may
// overlap and hollows may be shells turned inwards. Level: the distance to the triangles, negative inside: the
// signed distance (inside of overlapping shells at most that). Throws Error, naming the first such place,
// unless all is finite, and every edge is passed as often in one direction as in the other (the mesh is closed
// and consistently oriented), and it holds a volume. `text` is what describe() gives.
RegionPtr solid(TriangleMesh mesh, const std::string& text);

}  // namespace s2nnds
