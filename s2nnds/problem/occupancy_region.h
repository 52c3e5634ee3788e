// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/problem/occupancy_map.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {

// The occupied cells of a map. Cells of which nothing is known, and all beyond the map, count as occupied too
// if `unknown_is_occupied`, else as free. The cells' sides lie at whole multiples of the resolution, rounded.
// Level: the signed distance. `text` is what describe() gives. Throws Error unless both kinds are there.
RegionPtr occupied_cells(const OccupancyMap& map, bool unknown_is_occupied, const std::string& text);

}  // namespace s2nnds
