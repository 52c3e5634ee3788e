// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/region.h"

namespace s2nnds {

// normals x <= offsets, normals [k, n], offsets [k]. Level: the greatest signed distance from the half-spaces,
// inside the signed distance, outside at most the distance. Throws Error unless there is a half-space and each
// is as halfspace() asks.
RegionPtr polytope(const Points& normals, const Vector& offsets);
// The convex hull of vertices [V, 3] in space, at most 200, as the half-spaces of its faces, each moved
// outwards until, rounding included, it holds every vertex; or of vertices [V, 2] in the plane, as the polygon
// of its corners. Throws Error unless the hull has a volume.
RegionPtr convex_hull(const Points& vertices);

}  // namespace s2nnds
