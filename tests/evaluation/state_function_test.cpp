// SPDX-License-Identifier: BSD-3-Clause
// A callable is evaluated by the same code as a network.
#include "s2nnds/evaluation/state_function.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/evaluation/robustness.h"
#include "s2nnds/evaluation/safe_area.h"
#include "s2nnds/evaluation/trajectory_metrics.h"

namespace s2nnds {
namespace {

// x(t) = e^-t (cos 2t, sin 2t) from (1, 0).
const Points kSpiral{{-1.0, -2.0}, {2.0, -1.0}};
Points spiral(const Points& x) { return x * kSpiral.transpose(); }
NetworkWeights spiral_network() {
  return {.layers = {{.weight = kSpiral, .bias = {}, .activation = Activation::identity}}};
}
Vector left_half(const Points& x) { return x.col(0); }

SafetyProblem problem_with_ball() {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = empty_region(2);
  problem.unsafe = ball(Vector{{0.5, 0.4}}, 0.1);
  return problem;
}

Demonstration shown_by_the_spiral() {
  Demonstration shown;
  shown.time = Vector::LinSpaced(200, 0.0, 3.0);
  shown.position.resize(200, 2);
  for (Eigen::Index i = 0; i < 200; ++i) {
    const double t = shown.time[i];
    shown.position.row(i) = -0.8 * std::exp(-t) * Eigen::RowVector2d(std::cos(2 * t), std::sin(2 * t));
  }
  shown.velocity = spiral(shown.position);
  return shown;
}

TEST(StateFunction, OfACallableIsFollowedExactly) {
  const Rollout motion = roll_out(spiral, problem_with_ball(), Vector{{-0.9, 0.0}});
  EXPECT_EQ(motion.stop, StopReason::reached_goal);
  EXPECT_NEAR(motion.time[motion.time.size() - 1], std::log(0.9 / 0.02), 1e-4);
  const Points position = roll_out_at(spiral, Vector{{1.0, 0.0}}, Vector{{0.0, 1.0}});
  EXPECT_NEAR(position(1, 0), std::exp(-1.0) * std::cos(2.0), 1e-5);
  EXPECT_NEAR(position(1, 1), std::exp(-1.0) * std::sin(2.0), 1e-5);
}

TEST(StateFunction, OfACallableHasTheFiguresOfTheSameNetwork) {
  const SafetyProblem problem = problem_with_ball();
  const NetworkWeights network = spiral_network();
  const Points starts{{0.6, 0.3}, {-0.9, 0.0}, {0.5, 0.45}};
  EXPECT_EQ(rollout_is_safe(spiral, problem, starts), (std::vector<bool>{false, true, false}));
  EXPECT_EQ(rollout_is_safe(network, problem, starts), (std::vector<bool>{false, true, false}));

  const std::vector<Demonstration> shown = {shown_by_the_spiral()};
  for (const MotionErrors& errors : {motion_errors(spiral, shown), motion_errors(network, shown)}) {
    EXPECT_LT(errors.mse, 1e-25);
    EXPECT_LT(errors.dtw, 1e-5);
  }

  const SafeArea area = measure_safe_area(spiral, left_half, problem, 40);
  EXPECT_DOUBLE_EQ(area.safe_area, 2.0);
  EXPECT_NEAR(area.true_safe_area, measure_safe_area(network, left_half, problem, 40).true_safe_area, 0.02);

  const RobustnessOptions few{.grid = 6, .repetitions = 2};
  const auto ours = measure_robustness(spiral, StateFunction(left_half), problem, shown, 3, few);
  const auto same = measure_robustness(network, StateFunction(left_half), problem, shown, 3, few);
  ASSERT_EQ(ours.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(ours[k].converged, same[k].converged);
    EXPECT_EQ(ours[k].covered, same[k].covered);
    EXPECT_NEAR(ours[k].time_to_goal, same[k].time_to_goal, 1e-9);
  }
}

TEST(StateFunction, OfAnotherShapeIsRefused) {
  const SafetyProblem problem = problem_with_ball();
  const Vector start{{0.5, 0.0}};
  EXPECT_THROW(roll_out(left_half, problem, start), Error);
  EXPECT_THROW(roll_out_at(left_half, start, Vector{{1.0}}), Error);
  EXPECT_THROW(rollout_is_safe(left_half, problem, start.transpose()), Error);
  EXPECT_THROW(sublevel_area(spiral, problem.workspace, 10), Error);
  EXPECT_THROW(motion_errors(left_half, {shown_by_the_spiral()}), Error);
}

}  // namespace
}  // namespace s2nnds
