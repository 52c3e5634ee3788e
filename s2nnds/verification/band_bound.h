// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/verification/taylor_model.h"

namespace s2nnds {

// Above every value of q at those points of each box of the tile at which |level| <= band, level a form on the same tile and
// band >= 0; NaN where nothing is known. By q <= q - l level + |l| band, which holds there for every number l: of the
// right side's polynomial, much of what both change by across the box cancels.
TileRow upper_within(const TileForm& q, const TileForm& level, double band, const BoxTile& tile);
// The same wherever level(x) <= 0.
TileRow upper_below(const TileForm& q, const TileForm& level, const BoxTile& tile);

}  // namespace s2nnds
