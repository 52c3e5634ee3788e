// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/dynamic_time_warping.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// The best path to a pair, but for its last step.
struct Best {
  double cost = std::numeric_limits<double>::infinity();
  Eigen::Index length = 0;

  bool operator<(const Best& other) const {
    return cost < other.cost || (cost == other.cost && length < other.length);
  }
};

constexpr std::uint8_t both = 0, first = 1, second = 2;  // which curve advances to a pair
using Steps = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

WarpingPath follow_back(const Steps& steps, double cost) {
  WarpingPath path{cost, {}};
  for (Eigen::Index i = steps.rows() - 1, j = steps.cols() - 1; i >= 0 && j >= 0;) {
    path.pairs.emplace_back(i, j);
    const std::uint8_t step = i == 0 && j > 0 ? second : j == 0 && i > 0 ? first : steps(i, j);
    if (step != second) --i;
    if (step != first) --j;
  }
  return path;
}

}  // namespace

WarpingPath warp(const Points& cost) {
  check(cost.size() > 0, "time warping: found costs [{}, {}], expected at least one sample of each curve",
        cost.rows(), cost.cols());
  Steps steps(cost.rows(), cost.cols());
  std::vector<Best> above(static_cast<std::size_t>(cost.cols()) + 1), row = above;
  above[0] = {0.0, 0};
  for (Eigen::Index i = 0; i < cost.rows(); ++i) {
    row[0] = {};
    for (Eigen::Index j = 0; j < cost.cols(); ++j) {
      const auto at = static_cast<std::size_t>(j);
      const Best* best = &above[at];
      steps(i, j) = both;
      if (above[at + 1] < *best) best = &above[at + 1], steps(i, j) = first;
      if (row[at] < *best) best = &row[at], steps(i, j) = second;
      row[at + 1] = {best->cost + cost(i, j), best->length + 1};
    }
    std::swap(above, row);
  }
  return follow_back(steps, above.back().cost);
}

}  // namespace s2nnds
