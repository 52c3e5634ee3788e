// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "s2nnds/verification/prover.h"

namespace s2nnds {

// Where a supremum is taken, within the workspace.
enum class BarrierSet {
  inside,     // {B <= 0}
  level_set,  // {B = 0}
};

// Above some size >= 0 at every place of each box of the tile; NaN where nothing is known. Used by one thread only.
using TileSize = std::function<TileRow(const BoxTile&)>;

// Above the size wherever the set is: by some per cent more than the largest, or what the smallest boxes' bounds allow.
// Infinite where nothing is known. `size` makes one for each thread, on whose number the result does not depend.
double supremum(const ProofFunctions& functions, const Box& workspace, BarrierSet set,
                const std::function<TileSize()>& size);

}  // namespace s2nnds
