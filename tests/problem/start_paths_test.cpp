// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/start_paths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// From (1, height) straight to the origin, with velocity 1 in x.
Demonstration straight(double height) {
  constexpr Eigen::Index kSamples = 201;
  Demonstration d;
  d.time = Vector::LinSpaced(kSamples, 0.0, 1.0);
  d.position.resize(kSamples, 2);
  d.velocity.resize(kSamples, 2);
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    const double left = 1.0 - d.time[i];
    d.position.row(i) << left, height * left;
    d.velocity.row(i) << -1.0, -height;
  }
  return d;
}

Points start(double x, double y) { return (Points(1, 2) << x, y).finished(); }

TEST(StartPaths, FollowTheNearestDemonstrationAndComeNearerToIt) {
  const std::vector<Demonstration> shown = {straight(0.0), straight(1.0)};
  EXPECT_EQ(nearest_start(shown, Vector(start(1.0, 0.4).transpose())), 0U);
  EXPECT_EQ(nearest_start(shown, Vector(start(1.0, 0.6).transpose())), 1U);
  const auto paths = start_paths(shown, start(1.0, 0.2), 1000);
  ASSERT_EQ(paths.size(), 1U);
  const Demonstration& path = paths[0];
  EXPECT_NEAR(path.position(0, 1), 0.2, 1e-12);
  for (Eigen::Index i = 0; i < path.samples(); ++i) {
    const double x = path.position(i, 0);
    EXPECT_NEAR(path.position(i, 1), 0.2 * x * x, 1e-9);  // the share of the path that is left is x
    EXPECT_GE(path.position(i, 1), 0.01 - 1e-9);          // what is nearer than this was shown
  }
}

TEST(StartPaths, VelocitiesAreThoseOfThePath) {
  const Demonstration path = start_paths({straight(0.0)}, start(1.1, 0.3), 1000).at(0);
  for (Eigen::Index i = 1; i + 1 < path.samples(); ++i) {
    const Vector moved = (path.position.row(i + 1) - path.position.row(i - 1)).transpose() /
                         (path.time[i + 1] - path.time[i - 1]);
    EXPECT_LT((moved - path.velocity.row(i).transpose()).norm(), 1e-6) << i;
  }
}

TEST(StartPaths, AreThinnedAndLeftOutWhereTheyTellNothing) {
  EXPECT_EQ(start_paths({straight(0.0)}, start(1.0, 0.3), 20).at(0).samples(), 20);
  EXPECT_TRUE(start_paths({straight(0.0)}, start(1.0, 0.02), 20).empty());
  EXPECT_THROW(start_paths({}, start(1.0, 0.3), 20), Error);
  EXPECT_THROW(start_paths({straight(0.0)}, start(1.0, 0.3), 1), Error);
  const Points still = Points::Constant(5, 2, 0.5);
  EXPECT_EQ(displacement_along(still), Vector::Zero(5));
}

TEST(StartPaths, SpreadStartsCoverTheInitialSetFarthestFirst) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 2.0);
  problem.initial = box_region(Box{(Vector(2) << 0.9, -0.1).finished(), (Vector(2) << 1.1, 0.9).finished()});
  RandomStream random(0, "test");
  const Points starts = spread_starts(problem, {straight(0.0)}, 32, random);
  ASSERT_EQ(starts.rows(), 32);
  EXPECT_GT(starts(0, 1), 0.8);  // (1, 0) was shown
  EXPECT_LE(problem.initial->level(starts).maxCoeff(), 0.0);
  // Every point of X0 has one of them near it.
  for (double y = -0.1; y <= 0.9; y += 0.1)
    EXPECT_LT((starts.rowwise() - start(1.0, y).row(0)).rowwise().norm().minCoeff(), 0.15) << y;
  problem.initial = nullptr;
  EXPECT_EQ(spread_starts(problem, {straight(0.0)}, 32, random).rows(), 0);
}

}  // namespace
}  // namespace s2nnds
