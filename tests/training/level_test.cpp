// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/level.h"

#include <gtest/gtest.h>

namespace s2nnds {
namespace {

NetworkWeights affine(const Points& weight, const Vector& bias) {
  return {.layers = {{.weight = weight, .bias = bias, .activation = Activation::identity}}};
}

// B(x) = x1 - 0.2 on [-1, 1]^2, X0 left of -0.5, the obstacle right of `edge`.
SafetyProblem problem_with_edge(double edge) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = box_region({Vector{{-1.0, -1.0}}, Vector{{-0.5, 1.0}}});
  problem.unsafe = box_region({Vector{{edge, -1.0}}, Vector{{1.0, 1.0}}});
  return problem;
}

Networks networks_with(const NetworkWeights& f) {
  return {f, affine(Points{{1.0, 0.0}}, Vector{{0.0}}), affine(Points{{1.0, 0.0}}, Vector{{-0.2}})};
}

std::optional<double> largest(const NetworkWeights& f, double edge, const LevelOptions& options = {}) {
  RandomStream random(3, "level");
  return LevelChoice(problem_with_edge(edge), options).largest(networks_with(f), random);
}

const NetworkWeights to_the_left = affine(Points::Zero(2, 2), Vector{{-1.0, 0.0}});

TEST(Level, StopsAtTheObstacle) {
  const auto c = largest(to_the_left, 0.25);
  ASSERT_TRUE(c);
  EXPECT_NEAR(*c, 0.05 - 0.005, 1e-3);
}

TEST(Level, RetreatsFromAnObstacleWithinTheSafeSet) {
  const auto c = largest(to_the_left, 0.15);
  ASSERT_TRUE(c);
  EXPECT_NEAR(*c, -0.05 - 0.005, 1e-3);
}

TEST(Level, GoesNoFartherThanItsReach) {
  EXPECT_EQ(largest(to_the_left, 0.9), 0.1);
  EXPECT_EQ(largest(to_the_left, 0.9, {.reach = 0.02}), 0.02);
  EXPECT_FALSE(largest(to_the_left, 0.05)) << "B on the obstacle begins at -0.15";
}

TEST(Level, KeepsToWhereTheBarrierDecreases) {
  // Bdot = 0.1 x1 - 0.04: above -0.03 for x1 > 0.1, which is B > -0.1. No level of the reach is free then.
  EXPECT_FALSE(largest(affine(Points{{0.1, 0.0}, {0.0, 0.0}}, Vector{{-0.04, 0.0}}), 0.9));
  // Above it for x1 > 0.2, which is B > 0: 1.5 bands below that.
  const auto c = largest(affine(Points{{0.1, 0.0}, {0.0, 0.0}}, Vector{{-0.05, 0.0}}), 0.9);
  ASSERT_TRUE(c);
  EXPECT_NEAR(*c, -0.015, 1e-3);
}

TEST(Level, TheSafestLeavesTheMarginsThatAreWanted) {
  // B on the obstacle begins at 0.05, the margin that is wanted there: at c = 0.
  RandomStream random(3, "level");
  const LevelChoice choice(problem_with_edge(0.25), {});
  const auto c = choice.safest(networks_with(to_the_left), random);
  ASSERT_TRUE(c);
  EXPECT_LE(*c, 1e-3);
  EXPECT_NEAR(*c, 0.0, 5e-3);
}

TEST(Level, TheSafestSharesWhatThereIs) {
  // Bdot = 0.1 x1 - 0.025 = 0.1 B - 0.005 is far from the -0.05 that is wanted, the better the lower the level.
  RandomStream random(3, "level");
  const auto networks = networks_with(affine(Points{{0.1, 0.0}, {0.0, 0.0}}, Vector{{-0.025, 0.0}}));
  const auto c = LevelChoice(problem_with_edge(0.25), {}).safest(networks, random);
  ASSERT_TRUE(c);
  EXPECT_NEAR(*c, -0.1, 5e-3);
  EXPECT_FALSE(LevelChoice(problem_with_edge(0.05), {}).safest(networks, random)) << "no c leaves the slack";
}

}  // namespace
}  // namespace s2nnds
