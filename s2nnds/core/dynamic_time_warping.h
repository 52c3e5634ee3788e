// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "s2nnds/core/points.h"

namespace s2nnds {

// A way to match the samples of two curves in order.
struct WarpingPath {
  double cost = 0.0;  // sum of the costs of its pairs
  // (sample of the first curve, sample of the second), from the curves' ends back to (0, 0)
  std::vector<std::pair<Eigen::Index, Eigen::Index>> pairs;
};

// Dynamic time warping (Sakoe and Chiba, 1978): the path of least cost, the shortest of these. cost [M, K],
// M, K >= 1: what it costs to match sample i of the first curve with sample j of the second. A path advances
// by (1, 0), (0, 1) or (1, 1). Throws Error on an empty matrix.
WarpingPath warp(const Points& cost);

}  // namespace s2nnds
