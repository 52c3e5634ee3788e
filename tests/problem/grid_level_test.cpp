// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/grid_level.h"

#include <gtest/gtest.h>

namespace s2nnds {
namespace {

std::vector<Vector> cube_axes(Eigen::Index n, Eigen::Index side) {
  return std::vector<Vector>(static_cast<std::size_t>(n), Vector::LinSpaced(side, -1.0, 1.0));
}

TEST(GridLevel, PointsRunFastestAlongTheLastAxis) {
  const Points x = grid_points({Vector{{0.0, 1.0}}, Vector{{5.0, 6.0, 7.0}}});
  EXPECT_EQ(x, (Points{{0, 5}, {0, 6}, {0, 7}, {1, 5}, {1, 6}, {1, 7}}));
}

TEST(GridLevel, IsTheLevelOfSetsThatThePointsMeet) {
  for (const Eigen::Index n : {2, 3}) {
    const RegionPtr set = ball(Vector::Constant(n, 0.1), 0.4);
    const std::vector<Vector> axes = cube_axes(n, 41);
    EXPECT_EQ(grid_level(*set, axes), set->level(grid_points(axes)));
    EXPECT_EQ(grid_level(*empty_region(n), axes), empty_region(n)->level(grid_points(axes)));
  }
}

TEST(GridLevel, ShowsWhatFallsBetweenThePoints) {
  // Spacing 0.1; a plate of a tenth of it, and a ball of a fifth.
  const std::vector<Vector> axes = cube_axes(3, 21);
  const Points points = grid_points(axes);
  const RegionPtr plate = box_region({Vector{{-0.53, -0.53, 0.045}}, Vector{{0.53, 0.53, 0.055}}});
  const RegionPtr dot = ball(Vector{{0.87, 0.86, 0.86}}, 0.02);
  for (const RegionPtr& set : {plate, dot, unite({plate, dot})}) {
    ASSERT_GT(set->level(points).minCoeff(), 0.0);
    const Vector shown = grid_level(*set, axes);
    Eigen::Index inside = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const Box cell{points.row(i).transpose().array() - 0.05, points.row(i).transpose().array() + 0.05};
      if (shown[i] > 0.0) continue;
      ++inside;
      EXPECT_NE(set->classify(cell), Location::outside);
    }
    EXPECT_GE(inside, set == dot ? 1 : 11 * 11);
  }
}

TEST(GridLevel, TakesLevelsThatAreNoDistances) {
  const std::vector<Vector> axes = cube_axes(2, 21);
  const RegionPtr line = expression("100 * abs(y - 0.05) - 1", 2);
  ASSERT_GT(line->level(grid_points(axes)).minCoeff(), 0.0);
  EXPECT_LE(grid_level(*line, axes).minCoeff(), 0.0);
}

}  // namespace
}  // namespace s2nnds
