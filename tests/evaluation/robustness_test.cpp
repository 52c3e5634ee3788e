// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/robustness.h"

#include <gtest/gtest.h>

#include <cmath>

namespace s2nnds {
namespace {

NetworkWeights linear(const Points& weight) {
  return {.layers = {{.weight = weight, .bias = {}, .activation = Activation::identity}}};
}

SafetyProblem problem_with(RegionOptions unsafe) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = empty_region(2);
  problem.unsafe = make_region(unsafe, 2);
  return problem;
}

std::vector<Demonstration> starting_at(double x, double y) {
  Demonstration demonstration;
  demonstration.position = Points{{x, y}, {0.0, 0.0}};
  return {demonstration};
}

RegionOptions ball(double x, double y, double radius) {
  RegionOptions options;
  options.type = "ball";
  options.center = {x, y};
  options.radius = radius;
  return options;
}

TEST(Robustness, OfAContractionIsKnownInClosedForm) {
  // xdot = -x: straight lines to the goal, there within 0.02 after log(r / 0.02).
  const SafetyProblem problem = problem_with(ball(0.0, 0.5, 0.1));
  const auto found =
      measure_robustness(linear(Points{{-1.0, 0.0}, {0.0, -1.0}}), {}, problem, starting_at(0.8, 0.0), 1);
  ASSERT_EQ(found.size(), 3U);
  for (const MotionOutcomes& outcomes : found) EXPECT_DOUBLE_EQ(outcomes.converged, outcomes.safe);
  // Of the grid the ball stops what starts in the cone behind it.
  EXPECT_EQ(found[0].starts, "grid");
  EXPECT_GT(found[0].converged, 0.9);
  EXPECT_LT(found[0].converged, 1.0);
  EXPECT_LE(found[0].closest, 0.02);
  // The ball is 0.4 from the goal and farther from anything near the x axis.
  EXPECT_EQ(found[1].starts, "perturbed");
  EXPECT_EQ(found[1].motions, 10);
  EXPECT_DOUBLE_EQ(found[1].converged, 1.0);
  EXPECT_NEAR(found[1].time_to_goal, std::log(0.8 / 0.02), 0.4);
  EXPECT_EQ(found[2].starts, "pushed");
  EXPECT_DOUBLE_EQ(found[2].safe, 1.0);
  EXPECT_GT(found[2].closest, 0.25);
  EXPECT_LT(found[2].closest, 0.42);
}

TEST(Robustness, OfADriftIsNil) {
  const NetworkWeights drift = {
      .layers = {
          {.weight = Points::Zero(2, 2), .bias = Vector{{1.0, 0.0}}, .activation = Activation::identity}}};
  const auto found = measure_robustness(drift, {}, problem_with({}), starting_at(0.0, 0.5), 1);
  for (const MotionOutcomes& outcomes : found) {
    EXPECT_LE(outcomes.converged, 0.1);
    EXPECT_TRUE(std::isnan(outcomes.closest)) << "there is no obstacle";
  }
  EXPECT_DOUBLE_EQ(found[1].safe, 0.0);
}

TEST(Robustness, SameSeedSameFigures) {
  const SafetyProblem problem = problem_with(ball(0.0, 0.5, 0.1));
  const NetworkWeights f = linear(Points{{-1.0, -2.0}, {2.0, -1.0}});
  const RobustnessOptions small{.grid = 4};
  const auto once = measure_robustness(f, {}, problem, starting_at(0.8, 0.0), 7, small),
             again = measure_robustness(f, {}, problem, starting_at(0.8, 0.0), 7, small),
             other = measure_robustness(f, {}, problem, starting_at(0.8, 0.0), 8, small);
  EXPECT_EQ(once[2].mean_closest, again[2].mean_closest);
  EXPECT_NE(once[2].mean_closest, other[2].mean_closest);
}

TEST(Robustness, DistancesAreThoseToTheBoundary) {
  // From (0.8, 0) straight to within 0.02 of the goal, which is 0.4 from the ball.
  const SafetyProblem problem = problem_with(ball(0.0, 0.5, 0.1));
  const RobustnessOptions still{.grid = 2, .repetitions = 1, .perturbation = 0.0};
  const auto found = measure_robustness(linear(Points{{-1.0, 0.0}, {0.0, -1.0}}), {}, problem,
                                        starting_at(0.8, 0.0), 1, still);
  const double expected = std::hypot(0.02, 0.5) - 0.1;
  EXPECT_GT(found[1].closest, expected - 1e-3);
  EXPECT_LT(found[1].closest, expected + 1e-3);
  EXPECT_EQ(found[1].closest, found[1].mean_closest);
}

TEST(Robustness, ACertificateSpeaksOfWhatStartsInTheSafeSet) {
  // Straight lines to the goal past a ball in the upper half; {B <= 0} is the lower half.
  const SafetyProblem problem = problem_with(ball(0.0, 0.5, 0.1));
  const NetworkWeights lower_half = {
      .layers = {{.weight = Points{{0.0, 1.0}}, .bias = Vector{{0.0}}, .activation = Activation::identity}}};
  const NetworkWeights contraction = linear(Points{{-1.0, 0.0}, {0.0, -1.0}});
  const auto found = measure_robustness(contraction, lower_half, problem, starting_at(0.8, -0.4), 1);
  EXPECT_EQ(found[0].covered, 200) << "half of the grid";
  EXPECT_DOUBLE_EQ(found[0].covered_converged, 1.0);
  EXPECT_LT(found[0].converged, 1.0);
  EXPECT_GT(found[2].covered, 0);
  EXPECT_LT(found[2].covered, 10) << "some pushes lead out of it";
  const auto without = measure_robustness(contraction, {}, problem, starting_at(0.8, -0.4), 1);
  EXPECT_EQ(without[0].covered, 0);
  EXPECT_TRUE(std::isnan(without[0].covered_converged));
}

}  // namespace
}  // namespace s2nnds
