// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/detour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace s2nnds {
namespace {

constexpr double kClearance = 0.06;

// From (1, height, ...) to (0, height, ...), the coordinates after the first constant, in one second.
Demonstration level(const Vector& heights) {
  constexpr Eigen::Index kSamples = 401;
  const Eigen::Index n = 1 + heights.size();
  Demonstration d;
  d.time = Vector::LinSpaced(kSamples, 0.0, 1.0);
  d.position.resize(kSamples, n);
  d.velocity = Points::Zero(kSamples, n);
  d.position.col(0) = 1.0 - d.time.array();
  d.position.rightCols(n - 1).rowwise() = heights.transpose();
  d.velocity.col(0).setConstant(-1.0);
  return d;
}
Demonstration level(double height) { return level(Vector{{height}}); }

SafetyProblem problem_with(RegionPtr unsafe) {
  SafetyProblem problem;
  problem.workspace = problem.contained = Box::cube(unsafe->dimension(), 1.5);
  problem.unsafe = std::move(unsafe);
  return problem;
}

VelocityTargets around(const SafetyProblem& problem, const std::vector<Demonstration>& shown) {
  return detour_samples(problem, shown, kClearance);
}

TEST(Detour, KeepsJustClearOfABall) {
  const VelocityTargets way = around(problem_with(ball(Vector{{0.5, 0.02}}, 0.1)), {level(0.0)});
  ASSERT_GT(way.position.rows(), 100);
  double nearest = 1.0;
  for (Eigen::Index i = 0; i < way.position.rows(); ++i) {
    nearest = std::min(nearest, std::hypot(way.position(i, 0) - 0.5, way.position(i, 1) - 0.02) - 0.1);
    EXPECT_LT(way.position(i, 1), 0.0);  // below, where it is nearer
  }
  EXPECT_GT(nearest, kClearance);
  EXPECT_LT(nearest, 1.5 * kClearance + 0.02);  // a box of this size around it, and one step
}

TEST(Detour, VelocitiesFollowTheDisplacedPath) {
  const RegionPtr unsafe = box_region({Vector{{0.45, -0.1}}, Vector{{0.55, 0.05}}});
  const VelocityTargets way = around(problem_with(unsafe), {level(0.0)});
  ASSERT_GT(way.position.rows(), 100);
  for (Eigen::Index i = 1; i + 1 < way.position.rows(); ++i) {
    const double slope =
        (way.position(i + 1, 1) - way.position(i - 1, 1)) / (way.position(i + 1, 0) - way.position(i - 1, 0));
    EXPECT_DOUBLE_EQ(way.velocity(i, 0), -1.0);
    EXPECT_NEAR(way.velocity(i, 1) / way.velocity(i, 0), slope, 0.02);
    EXPECT_LT(std::abs(slope), std::numbers::pi / 6.0 + 0.02);  // half a cosine that rises by a third
    EXPECT_GT(way.position(i, 1), 0.0);
    EXPECT_LT(way.position(i, 1), 0.05 + kClearance + 0.03);
  }
}

TEST(Detour, DemonstrationsOnTwoSidesOfTheMiddleTakeOneWay) {
  const VelocityTargets way = around(problem_with(ball(Vector{{0.5, 0.0}}, 0.1)),
                                     {level(0.05), level(0.04), level(-0.02), level(0.3)});
  ASSERT_GT(way.position.rows(), 300);
  for (Eigen::Index i = 0; i < way.position.rows(); ++i) {
    const bool beside = std::abs(way.position(i, 0) - 0.5) < 0.1;
    EXPECT_GT(way.position(i, 1), beside ? 0.1 : -0.03);
    EXPECT_LT(way.position(i, 1), 0.29);  // the last passes beside: it stays
  }
}

TEST(Detour, OneObstacleAfterTheOther) {
  const RegionPtr unsafe = unite({ball(Vector{{0.75, 0.02}}, 0.08), ball(Vector{{0.3, -0.02}}, 0.08)});
  const VelocityTargets way = around(problem_with(unsafe), {level(0.0)});
  ASSERT_GT(way.position.rows(), 200);
  EXPECT_GT(unsafe->level(way.position).minCoeff(), kClearance);
  for (const double along : {0.75, 0.3}) {
    EXPECT_LT((way.position.col(0).array() - along).abs().minCoeff(), 0.01);
  }
}

TEST(Detour, GoesAroundInThreeDimensions) {
  const RegionPtr unsafe = ball(Vector{{0.5, 0.03, 0.02}}, 0.12);
  const VelocityTargets way = around(problem_with(unsafe), {level(Vector{{0.0, 0.0}})});
  ASSERT_GT(way.position.rows(), 100);
  EXPECT_GT(unsafe->level(way.position).minCoeff(), kClearance);
  EXPECT_LT(way.position.rightCols(2).rowwise().norm().maxCoeff(), 0.12 + 2.0 * kClearance);
}

TEST(Detour, NothingWhereNonePassesThrough) {
  EXPECT_EQ(around(problem_with(empty_region(2)), {level(0.0)}).position.rows(), 0);
  EXPECT_EQ(around(problem_with(ball(Vector{{0.5, 0.2}}, 0.15)), {level(0.0)}).position.rows(), 0);
  EXPECT_EQ(around(problem_with(ball(Vector{{0.5, 0.02}}, 0.1)), {}).position.rows(), 0);
}

TEST(Detour, NothingWhereNoWayLeadsAround) {
  const auto none = [](RegionPtr unsafe) {
    return around(problem_with(std::move(unsafe)), {level(0.0)}).position.rows() == 0;
  };
  EXPECT_TRUE(none(box_region({Vector{{0.4, -2.0}}, Vector{{0.6, 2.0}}})));  // a wall across the workspace
  EXPECT_TRUE(none(ball(Vector{{0.9, 0.0}}, 0.08)));                         // the start is within reach
  EXPECT_TRUE(none(ball(Vector{{0.1, 0.0}}, 0.08)));                         // the end is
}

}  // namespace
}  // namespace s2nnds
