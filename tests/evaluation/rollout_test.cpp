// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/rollout.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

constexpr double pi = std::numbers::pi;

NetworkWeights linear(const Points& weight, const Vector& bias = {}) {
  return {.layers = {{.weight = weight, .bias = bias, .activation = Activation::identity}}};
}

// x(t) = e^-t (cos 2t, sin 2t) from (1, 0).
NetworkWeights spiral() { return linear(Points{{-1.0, -2.0}, {2.0, -1.0}}); }
NetworkWeights circle() { return linear(Points{{0.0, -1.0}, {1.0, 0.0}}); }
NetworkWeights drift(double speed) { return linear(Points::Zero(2, 2), Vector{{speed, 0.0}}); }

SafetyProblem open_problem(double half_width = 2.0) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, half_width);
  problem.initial = empty_region(2);
  problem.unsafe = empty_region(2);
  return problem;
}

double longest_gap(const Points& position) {
  return (position.bottomRows(position.rows() - 1) - position.topRows(position.rows() - 1))
      .rowwise()
      .norm()
      .maxCoeff();
}

TEST(RollOut, FollowsTheExactSolutionToTheGoal) {
  const Rollout motion = roll_out(spiral(), open_problem(), Vector{{1.0, 0.0}});
  EXPECT_EQ(motion.stop, StopReason::reached_goal);
  EXPECT_NEAR(motion.time[motion.time.size() - 1], std::log(1.0 / 0.02), 1e-3);
  for (Eigen::Index i = 0; i < motion.time.size(); ++i) {
    const double t = motion.time[i];
    EXPECT_NEAR(motion.position(i, 0), std::exp(-t) * std::cos(2 * t), 1e-5);
    EXPECT_NEAR(motion.position(i, 1), std::exp(-t) * std::sin(2 * t), 1e-5);
  }
  EXPECT_NEAR(motion.position.bottomRows(1).norm(), 0.02, 1e-9);
  EXPECT_LE(longest_gap(motion.position), 0.005);
  EXPECT_TRUE(
      ((motion.time.tail(motion.time.size() - 1) - motion.time.head(motion.time.size() - 1)).array() > 0)
          .all());
}

TEST(RollOut, TightensWithItsTolerances) {
  RolloutOptions options{.absolute_tolerance = 1e-11, .relative_tolerance = 1e-11};
  const Rollout motion = roll_out(spiral(), open_problem(), Vector{{1.0, 0.0}}, options);
  EXPECT_NEAR(motion.time[motion.time.size() - 1], std::log(1.0 / 0.02), 1e-7);
}

TEST(RollOut, LocatesTheEntryIntoABall) {
  SafetyProblem problem = open_problem();
  problem.unsafe = ball(Vector{{0.0, 1.0}}, 0.3);
  const Rollout motion = roll_out(circle(), problem, Vector{{1.0, 0.0}});
  EXPECT_EQ(motion.stop, StopReason::entered_unsafe);
  EXPECT_NEAR(motion.time[motion.time.size() - 1], pi / 2 - 2 * std::asin(0.15), 1e-5);
}

TEST(RollOut, LocatesTheEntryOfASpiral) {
  SafetyProblem problem = open_problem();
  problem.unsafe = halfspace(Vector{{1.0, 0.0}}, -0.1);  // x1 <= -0.1
  double low = pi / 4, high = pi / 2;                    // e^-t cos 2t falls through -0.1 between these
  for (int i = 0; i < 60; ++i) {
    const double t = 0.5 * (low + high);
    (std::exp(-t) * std::cos(2 * t) > -0.1 ? low : high) = t;
  }
  const Rollout motion = roll_out(spiral(), problem, Vector{{1.0, 0.0}});
  EXPECT_EQ(motion.stop, StopReason::entered_unsafe);
  EXPECT_NEAR(motion.time[motion.time.size() - 1], low, 1e-5);
}

TEST(RollOut, DoesNotJumpOverAThinObstacle) {
  SafetyProblem problem = open_problem();
  problem.unsafe = box_region({Vector{{0.5, -0.1}}, Vector{{0.506, 0.1}}});
  for (const double speed : {0.01, 1.0, 50.0}) {
    const Rollout motion = roll_out(drift(speed), problem, Vector{{-1.0, 0.05}}, {.duration = 200.0});
    EXPECT_EQ(motion.stop, StopReason::entered_unsafe);
    EXPECT_NEAR(motion.time[motion.time.size() - 1] * speed, 1.5, 1e-6);
  }
}

TEST(RollOut, LeavesTheWorkspaceAndItsShell) {
  SafetyProblem problem = open_problem(1.0);
  Rollout motion = roll_out(drift(1.0), problem, Vector{{0.5, 0.1}});
  EXPECT_EQ(motion.stop, StopReason::left_workspace);
  EXPECT_NEAR(motion.time[motion.time.size() - 1], 0.5, 1e-9);
  problem.workspace_margin = complement(box_region(Box::cube(2, 0.97)));
  motion = roll_out(drift(1.0), problem, Vector{{0.5, 0.1}});
  EXPECT_EQ(motion.stop, StopReason::left_workspace);
  EXPECT_NEAR(motion.time[motion.time.size() - 1], 0.47, 1e-9);
}

TEST(RollOut, TimesOut) {
  const Rollout motion = roll_out(circle(), open_problem(), Vector{{1.0, 0.0}}, {.duration = 5.0});
  EXPECT_EQ(motion.stop, StopReason::time_out);
  EXPECT_EQ(motion.time[motion.time.size() - 1], 5.0);
  EXPECT_NEAR(motion.position(motion.position.rows() - 1, 0), std::cos(5.0), 1e-4);
}

TEST(RollOut, FailsHonestlyWhenTheMotionEscapes) {
  const RolloutOptions options{.stop_at_unsafe = false};
  const Rollout motion =
      roll_out(linear(1000.0 * Points::Identity(2, 2)), open_problem(), Vector{{1.0, 0.0}}, options);
  EXPECT_EQ(motion.stop, StopReason::step_failed);
  EXPECT_TRUE(motion.position.allFinite());
}

// Towards the line x1 = 0 from both sides, where only ever shorter steps go on: nobody waits for these.
TEST(RollOut, GivesUpAMotionThatChatters) {
  const NetworkWeights chattering = {
      .layers = {{.weight = Points{{2e4, 0.0}}, .bias = Vector{{0.0}}, .activation = Activation::tanh},
                 {.weight = Points{{-1.0}, {0.0}}, .bias = {}, .activation = Activation::identity}}};
  const Rollout motion = roll_out(chattering, open_problem(), Vector{{0.2, 0.5}});
  EXPECT_EQ(motion.stop, StopReason::step_failed);
  EXPECT_NEAR(motion.position(motion.position.rows() - 1, 0), 0.0, 1e-3);
}

TEST(RollOut, StopsOnlyWhereAsked) {
  SafetyProblem problem = open_problem();
  problem.unsafe = ball(Vector{{0.0, 1.0}}, 0.3);
  Rollout motion =
      roll_out(circle(), problem, Vector{{1.0, 0.0}}, {.duration = 3.0, .stop_at_unsafe = false});
  EXPECT_EQ(motion.stop, StopReason::time_out);
  motion = roll_out(spiral(), open_problem(), Vector{{1.0, 0.0}}, {.duration = 10.0, .stop_at_goal = false});
  EXPECT_EQ(motion.time[motion.time.size() - 1], 10.0);
  EXPECT_LT(motion.position.bottomRows(1).norm(), 1e-3);
}

TEST(RollOut, JudgesTheStart) {
  SafetyProblem problem = open_problem();
  problem.unsafe = ball(Vector{{1.0, 0.0}}, 0.1);
  EXPECT_EQ(roll_out(spiral(), problem, Vector{{1.0, 0.05}}).stop, StopReason::entered_unsafe);
  EXPECT_EQ(roll_out(spiral(), problem, Vector{{0.0, 0.01}}).stop, StopReason::reached_goal);
  EXPECT_EQ(roll_out(spiral(), problem, Vector{{0.0, 2.01}}).stop, StopReason::left_workspace);
  EXPECT_EQ(roll_out(spiral(), problem, Vector{{0.0, 2.01}}).time.size(), 1);
}

TEST(RollOut, RefusesMisuse) {
  EXPECT_THROW(roll_out(spiral(), open_problem(), Vector{{1.0, 0.0, 0.0}}), Error);
  EXPECT_THROW(roll_out(spiral(), open_problem(), Vector{{1.0, std::nan("")}}), Error);
  EXPECT_THROW(roll_out(linear(Points{{1.0, 1.0}}), open_problem(), Vector{{1.0, 0.0}}), Error);
  EXPECT_THROW(roll_out(spiral(), open_problem(), Vector{{1.0, 0.0}}, {.duration = -1.0}), Error);
}

TEST(RollOutAt, GivesTheExactPositions) {
  const Vector times{{0.0, 0.0, 0.3, 1.0, 1.0, 7.5}};
  const Points position = roll_out_at(spiral(), Vector{{1.0, 0.0}}, times);
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(position(i, 0), std::exp(-times[i]) * std::cos(2 * times[i]), 1e-5);
    EXPECT_NEAR(position(i, 1), std::exp(-times[i]) * std::sin(2 * times[i]), 1e-5);
  }
}

TEST(RollOutAt, RefusesDescendingTimesAndShowsEscape) {
  EXPECT_THROW(roll_out_at(spiral(), Vector{{1.0, 0.0}}, Vector{{1.0, 0.5}}), Error);
  EXPECT_THROW(roll_out_at(spiral(), Vector{{1.0, 0.0}}, Vector{{-1.0, 0.5}}), Error);
  const Points position =
      roll_out_at(linear(1000.0 * Points::Identity(2, 2)), Vector{{1.0, 0.0}}, Vector{{0.001, 50.0}});
  EXPECT_NEAR(position(0, 0), std::exp(1.0), 1e-4);
  EXPECT_TRUE(std::isnan(position(1, 0)));
}

// f(x) = -W tanh(x) + a random bounded disturbance, f(0) = 0: turns, slows, and for some starts does not
// arrive.
NetworkWeights nonlinear_field() {
  RandomStream random(11, "test");
  Layer hidden{.weight = Points::Zero(18, 2), .bias = Vector::Zero(18), .activation = Activation::tanh};
  Layer output{.weight = Points::Zero(2, 18), .bias = {}, .activation = Activation::identity};
  hidden.weight.topRows(2) = Points::Identity(2, 2);
  output.weight.leftCols(2) << -1.0, -1.5, 1.5, -1.0;
  for (Eigen::Index i = 2; i < 18; ++i) {
    hidden.bias[i] = random.normal();
    for (Eigen::Index k = 0; k < 2; ++k) {
      hidden.weight(i, k) = 3.0 * random.normal();
      output.weight(k, i) = 0.05 * random.normal();
    }
  }
  return {.layers = {hidden, output}, .head = Head::zero_at_origin};
}

SafetyProblem crowded_problem(double grown) {
  SafetyProblem problem = open_problem(1.25);
  problem.unsafe =
      unite({ball(Vector{{0.5, 0.4}}, 0.2 + grown),
             box_region({Vector{{-0.8 - grown, -0.3 - grown}}, Vector{{-0.5 + grown, -0.28 + grown}}})});
  problem.workspace_margin = complement(box_region(Box::cube(2, 1.2 - grown)));
  return problem;
}

TEST(RolloutIsSafe, AgreesWithTheAdaptiveRollouts) {
  const NetworkWeights f = nonlinear_field();
  RandomStream random(12, "test");
  Points starts(600, 2);
  for (double& value : starts.reshaped()) value = random.uniform(-1.25, 1.25);
  const std::vector<bool> labels = rollout_is_safe(f, crowded_problem(0.0), starts);
  const auto arrives = [&](double grown, Eigen::Index i) {
    const RolloutOptions options{.duration = 40.0};
    return roll_out(f, crowded_problem(grown), starts.row(i).transpose(), options).stop ==
           StopReason::reached_goal;
  };
  int safe = 0, grazing = 0;
  for (Eigen::Index i = 0; i < starts.rows(); ++i) {
    const bool label = labels[static_cast<std::size_t>(i)];
    safe += label ? 1 : 0;
    // Motions that pass a set's edge within 0.003 may be judged either way.
    const bool strict = arrives(0.003, i);
    if (strict != arrives(-0.003, i)) {
      ++grazing;
    } else {
      EXPECT_EQ(label, strict) << starts.row(i);
    }
  }
  EXPECT_GT(safe, 100);
  EXPECT_LT(safe, 500);
  EXPECT_LT(grazing, 30);
}

TEST(RolloutIsSafe, DoesNotJumpOverAThinObstacle) {
  // A long approach at constant speed, where the steps grow to their limit.
  SafetyProblem problem = open_problem(10.0);
  problem.unsafe = box_region({Vector{{-1.006, -0.1}}, Vector{{-1.0, 0.1}}});
  const NetworkWeights f{
      .layers = {{.weight = Points{{5.0, 0.0}, {0.0, 5.0}}, .bias = {}, .activation = Activation::tanh},
                 {.weight = -3.0 * Points::Identity(2, 2), .bias = {}}}};
  const std::vector<bool> safe =
      rollout_is_safe(f, problem, Points{{-9.0, 0.0}, {-9.0, 9.0}, {9.0, 0.0}, {-5.0, 0.05}});
  EXPECT_EQ(safe, (std::vector<bool>{false, true, true, false}));
}

TEST(RolloutIsSafe, KnownVerdicts) {
  SafetyProblem problem = open_problem(1.0);
  problem.unsafe = ball(Vector{{0.6, 0.0}}, 0.1);
  const Points starts{{0.9, 0.0}, {-0.9, 0.0}, {0.6, 0.05}, {0.0, 0.01}, {0.4, 0.0}, {1.01, -0.5}};
  const std::vector<bool> expected = {false, true, false, true, true, false};
  EXPECT_EQ(rollout_is_safe(linear(-Points::Identity(2, 2)), problem, starts), expected);
  EXPECT_EQ(rollout_is_safe(circle(), problem, Points{{-0.3, 0.0}}),
            std::vector<bool>{false});  // never arrives
  EXPECT_EQ(rollout_is_safe(linear(Points::Identity(2, 2)), problem, Points{{-0.3, 0.0}}),
            std::vector<bool>{false});
  EXPECT_TRUE(rollout_is_safe(circle(), problem, Points(0, 2)).empty());
}

// Another region's level, which may keep to itself that it is 1-Lipschitz; counts the points that were asked for.
class Counted final : public Region {
 public:
  Counted(RegionPtr region, bool says_it) : region_(std::move(region)), says_it_(says_it) {}
  Eigen::Index dimension() const override { return region_->dimension(); }
  bool is_lipschitz() const override { return says_it_ && region_->is_lipschitz(); }
  std::string describe() const override { return region_->describe(); }
  Eigen::Index count() const { return count_; }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    count_ += x.rows();
    level = region_->level(x);
  }
  Interval enclose(const Box& box) const override { return region_->enclosure(box); }

 private:
  RegionPtr region_;
  bool says_it_;
  mutable std::atomic<Eigen::Index> count_ = 0;
};

TEST(RolloutIsSafe, ComputesFewLevelsThatAreDistances) {
  const NetworkWeights f = nonlinear_field();
  RandomStream random(13, "test");
  Points starts(600, 2);
  for (double& value : starts.reshaped()) value = random.uniform(-1.25, 1.25);
  SafetyProblem problem = crowded_problem(0.0);
  ASSERT_TRUE(problem.unsafe->is_lipschitz());
  const auto every = std::make_shared<Counted>(problem.unsafe, false);
  const auto few = std::make_shared<Counted>(problem.unsafe, true);
  problem.unsafe = every;
  const std::vector<bool> expected = rollout_is_safe(f, problem, starts);
  problem.unsafe = few;
  EXPECT_EQ(rollout_is_safe(f, problem, starts), expected);
  EXPECT_LT(5 * few->count(), every->count());
}

TEST(RolloutIsSafe, AMotionWithoutValueIsUnsafe) {
  const NetworkWeights broken{.layers = {{.weight = Points{{1e200, 0.0}, {1e200, 0.0}}, .bias = {}},
                                         {.weight = Points{{1e200, -1e200}, {0.0, 0.0}}, .bias = {}}}};
  EXPECT_EQ(rollout_is_safe(broken, open_problem(), Points{{0.5, 0.5}}), std::vector<bool>{false});
}

TEST(RolloutIsSafe, RefusesMisuse) {
  EXPECT_THROW(rollout_is_safe(spiral(), open_problem(), Points::Zero(1, 3)), Error);
  EXPECT_THROW(rollout_is_safe(spiral(), open_problem(), Points{{std::nan(""), 0.0}}), Error);
  EXPECT_THROW(rollout_is_safe(spiral(), open_problem(), Points::Zero(1, 2), {.step = 0.0}), Error);
}

}  // namespace
}  // namespace s2nnds
