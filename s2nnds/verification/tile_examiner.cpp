// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/tile_examiner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "s2nnds/verification/rounding.h"

namespace s2nnds {

TileRow gradient_norm(ScalarEnclosure& function, const BoxTile& tile) {
  const TileModels& gradient = function.gradient(tile);
  TileRow sum;
  for (Eigen::Index d = 0; d < tile.dimension(); ++d) {
    const TileRow size = gradient.value(d).abs() + gradient.spread(d, tile) + gradient.deviation(d, tile);
    sum += (size * slack + underflow).square();
  }
  return sum.sqrt() * slack;
}

TileRow least_gradient_norm(ScalarEnclosure& function, const BoxTile& tile) {
  const TileModels& gradient = function.gradient(tile);
  TileRow sum;
  for (Eigen::Index d = 0; d < tile.dimension(); ++d) {
    const TileRow varies = (gradient.spread(d, tile) + gradient.deviation(d, tile)) * slack + underflow;
    sum += (gradient.value(d).abs() - varies).max(0.0).square();
  }
  return sum.sqrt() / (slack * slack);
}

void raise_to(std::atomic<double>& value, double candidate) {
  if (std::isnan(candidate)) candidate = std::numeric_limits<double>::infinity();
  double seen = value;
  while (candidate > seen && !value.compare_exchange_weak(seen, candidate)) {
  }
}

void TileExaminer::cut_for(const TileForm& rate) {
  const TileRow low = rate.lower(tile_);
  for (Eigen::Index lane = 0; lane < tile_boxes; ++lane) {
    const double remainder = rate.remainder(lane);
    cuts_[static_cast<std::size_t>(lane)] = useful_cuts(tile_.dimension(), low(lane) + remainder, remainder);
  }
}

void TileExaminer::examine(BoxBatch& batch) {
  std::vector<Eigen::Index> open(static_cast<std::size_t>(batch.count));
  std::iota(open.begin(), open.end(), batch.first);
  Points noted = Points::Zero(batch.count, std::ssize(noted_));
  const Eigen::Index n = tile_.dimension();
  for (int count = 0; !open.empty(); ++count) {
    std::vector<Eigen::Index> left;
    for (std::size_t first = 0; first < open.size(); first += tile_boxes) {
      const auto boxes = static_cast<Eigen::Index>(std::min<std::size_t>(tile_boxes, open.size() - first));
      Points lower(boxes, n), upper(boxes, n);
      for (Eigen::Index lane = 0; lane < tile_boxes; ++lane) {
        const Eigen::Index row = open[first + static_cast<std::size_t>(std::min(lane, boxes - 1))];
        carried_(lane) = batch.carried(row);
        for (std::size_t k = 0; k < noted_.size(); ++k)
          noted_[k](lane) = noted(row - batch.first, static_cast<Eigen::Index>(k));
        if (lane >= boxes) continue;
        lower.row(lane) = batch.lower.row(row);
        upper.row(lane) = batch.upper.row(row);
      }
      tile_.assign(lower, upper, 0, boxes);
      cuts_.fill(1);
      look(count);
      for (Eigen::Index lane = 0; lane < boxes; ++lane) {
        const Eigen::Index row = open[first + static_cast<std::size_t>(lane)];
        const bool narrow = (upper.row(lane) - lower.row(lane)).maxCoeff() <= resolution_;
        const std::optional<BoxStatus> status =
            judge(count, {lane, lower.row(lane), upper.row(lane), narrow});
        batch.carried(row) = carried_(lane);
        for (std::size_t k = 0; k < noted_.size(); ++k)
          noted(row - batch.first, static_cast<Eigen::Index>(k)) = noted_[k](lane);
        if (status) {
          batch.status[static_cast<std::size_t>(row)] = *status;
          batch.cuts[static_cast<std::size_t>(row)] = cuts_[static_cast<std::size_t>(lane)];
        } else {
          left.push_back(row);
        }
      }
    }
    open = std::move(left);
  }
}

}  // namespace s2nnds
