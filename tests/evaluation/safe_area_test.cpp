// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/safe_area.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr double pi = std::numbers::pi;

NetworkWeights linear(const Points& weight, const Vector& bias = {}) {
  return {.layers = {{.weight = weight, .bias = bias, .activation = Activation::identity}}};
}

StateFunction ball_level(double radius) {
  return [radius](const Points& x) -> Vector { return x.rowwise().norm().array() - radius; };
}

TEST(SublevelArea, OfBallsInTwoToFourDimensions) {
  EXPECT_NEAR(sublevel_area(ball_level(0.5), Box::cube(2, 1.0), 400), pi / 4, 1e-3);
  EXPECT_NEAR(sublevel_area(ball_level(0.7), Box::cube(3, 1.0), 100), 4.0 / 3.0 * pi * 0.343, 3e-3);
  // Sobol points: far nearer than the 0.04 that random ones would give.
  EXPECT_NEAR(sublevel_area(ball_level(0.9), Box::cube(4, 1.0), 40000), pi * pi / 2 * std::pow(0.9, 4), 0.02);
}

TEST(SublevelArea, OfAHalfPlaneInAnyBox) {
  const NetworkWeights plane = linear(Points{{1.0, 0.0}}, Vector::Constant(1, -0.25));  // x1 <= 0.25
  EXPECT_NEAR(sublevel_area(plane, {Vector{{-1.0, 2.0}}, Vector{{1.0, 5.0}}}, 80), 1.25 * 3.0, 1e-12);
}

TEST(SublevelArea, RefusesMisuse) {
  EXPECT_THROW(sublevel_area(ball_level(1.0), Box::cube(2, 1.0), 0), Error);
  EXPECT_THROW(sublevel_area(ball_level(1.0), Box::cube(2, INFINITY), 10), Error);
  EXPECT_THROW(sublevel_area(ball_level(1.0), Box::cube(3, 1.0), 5000), Error);
}

TEST(MeasureSafeArea, KnowsTheShadowOfAnObstacle) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = empty_region(2);
  problem.unsafe = ball(Vector{{0.5, 0.0}}, 0.2);
  const NetworkWeights f = linear(-Points::Identity(2, 2));  // straight to the goal
  const NetworkWeights B = linear(Points{{1.0, 0.0}}, Vector::Constant(1, -0.25));
  const SafeArea area = measure_safe_area(f, B, problem);
  EXPECT_NEAR(area.safe_area, 2.5, 1e-9);
  // Lost is the cone of half-angle a that the ball fills, up to the workspace's edge, but for its part before
  // the ball.
  const double a = std::asin(0.2 / 0.5);
  const double before = std::sqrt(0.25 - 0.04) * 0.2 - 0.04 * (pi / 2 - a);
  const double true_area = 4.0 - (std::tan(a) - before);
  EXPECT_NEAR(area.true_safe_area, true_area, 0.01);
  EXPECT_NEAR(area.ratio(), 2.5 / true_area, 0.003);
}

TEST(MeasureSafeArea, WorksInThreeDimensions) {
  SafetyProblem problem;
  problem.workspace = Box::cube(3, 1.0);
  problem.initial = empty_region(3);
  problem.unsafe = empty_region(3);
  problem.workspace_margin = complement(box_region(Box::cube(3, 0.9)));
  const SafeArea area =
      measure_safe_area(linear(-Points::Identity(3, 3)), linear(Points{{0.0, 0.0, 1.0}}), problem, 20);
  EXPECT_NEAR(area.safe_area, 4.0, 1e-9);
  EXPECT_NEAR(area.true_safe_area, 1.8 * 1.8 * 1.8, 1e-9);
}

}  // namespace
}  // namespace s2nnds
