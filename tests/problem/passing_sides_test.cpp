// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/passing_sides.h"

#include <gtest/gtest.h>

#include "s2nnds/problem/region.h"

namespace s2nnds {
namespace {

// From (-1, 0) to the goal, `height` above it halfway.
Demonstration bow(double height, Eigen::Index dimension = 2) {
  constexpr Eigen::Index kSamples = 51;
  Demonstration d;
  d.time = Vector::LinSpaced(kSamples, 0.0, 1.0);
  d.position = Points::Zero(kSamples, dimension);
  d.velocity = Points::Zero(kSamples, dimension);
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    const double s = d.time[i];
    d.position(i, 0) = s - 1.0;
    d.position(i, 1) = 4.0 * height * s * (1.0 - s);
  }
  return d;
}

SafetyProblem with_ball(double y, Eigen::Index dimension = 2) {
  SafetyProblem problem;
  problem.workspace = Box::cube(dimension, 1.25);
  Vector centre = Vector::Zero(dimension);
  centre[0] = -0.5;
  centre[1] = y;
  problem.unsafe = ball(centre, 0.1);
  return problem;
}

TEST(PassingSides, SeesAPairAroundTheObstacle) {
  const auto found = find_passing_sides(with_ball(0.0), {bow(0.2), bow(0.25), bow(-0.3)});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->first, 0U);
  EXPECT_EQ(found->second, 2U);
  EXPECT_LT((found->place - Vector{{-0.5, 0.0}}).norm(), 0.1001);
}

TEST(PassingSides, LetsOneSideAndOtherStartsPass) {
  EXPECT_FALSE(find_passing_sides(with_ball(0.0), {bow(0.2), bow(0.3)}));
  EXPECT_FALSE(find_passing_sides(with_ball(0.8), {bow(0.2), bow(-0.3)}));
  Demonstration elsewhere = bow(-0.3);
  elsewhere.position.row(0) << -1.0, -0.5;
  EXPECT_FALSE(find_passing_sides(with_ball(0.0), {bow(0.2), elsewhere}));
  EXPECT_FALSE(find_passing_sides(with_ball(0.0, 3), {bow(0.2, 3), bow(-0.3, 3)}));
}

}  // namespace
}  // namespace s2nnds
