// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/perturbation.h"

#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/tile_examiner.h"

namespace s2nnds {

TileRow BoundedPerturbation::work(ScalarEnclosure& function, const BoxTile& tile) {
  return size_ * gradient_norm(function, tile) * slack;
}

}  // namespace s2nnds
