// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/tile_examiner.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "s2nnds/verification/rounding.h"

namespace s2nnds {

TileRow gradient_norm(ScalarEnclosure& function, const BoxTile& tile) {
  TileRow sum;
  for (Eigen::Index d = 0; d < tile.dimension(); ++d) {
    const TileForm& partial = function.partial_derivative(tile, d);
    sum += partial.upper(tile).max(-partial.lower(tile)).square();
  }
  return sum.sqrt() * slack;
}

void raise_to(std::atomic<double>& value, double candidate) {
  if (std::isnan(candidate)) candidate = std::numeric_limits<double>::infinity();
  double seen = value;
  while (candidate > seen && !value.compare_exchange_weak(seen, candidate)) {
  }
}

void TileExaminer::examine(BoxBatch& batch) {
  for (Eigen::Index first = 0; first < batch.count; first += tile_boxes) {
    const Eigen::Index count = std::min<Eigen::Index>(tile_boxes, batch.count - first);
    tile_.assign(batch.lower, batch.upper, batch.first + first, count);
    evaluate();
    for (Eigen::Index lane = 0; lane < count; ++lane) {
      const Eigen::Index row = batch.first + first + lane;
      const Eigen::RowVectorXd lower = batch.lower.row(row), upper = batch.upper.row(row);
      const bool narrow = (upper - lower).maxCoeff() <= resolution_;
      batch.status[static_cast<std::size_t>(row)] = judge(lane, lower, upper, narrow);
    }
  }
}

}  // namespace s2nnds
