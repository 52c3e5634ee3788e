// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/conditions/condition.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

NetworkWeights linear(const Points& weight, const Vector& bias = {}) {
  return {.layers = {{.weight = weight, .bias = bias, .activation = Activation::identity}}};
}

// f = -x + swirl, V = |x|^2 + 0.5 |x|^2, B = x1 + 2 x2 - 0.5: all known in closed form.
Networks simple_networks() {
  Networks networks;
  networks.f = linear(Points{{-1.0, 2.0}, {-2.0, -1.0}});
  networks.V = linear(Points::Identity(2, 2));
  networks.V.head = Head::squared_norm;
  networks.V.quadratic = 0.5;
  networks.B = linear(Points{{1.0, 2.0}}, Vector::Constant(1, -0.5));
  return networks;
}

SafetyProblem simple_problem() {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = ball(Vector{{-0.5, -0.5}}, 0.1);
  problem.unsafe = ball(Vector{{0.5, 0.5}}, 0.2);
  problem.workspace_margin = complement(box_region(Box::cube(2, 0.95)));
  return problem;
}

double at(const Points& all, Eigen::Index row, Condition condition) {
  return all(row, static_cast<Eigen::Index>(condition));
}

TEST(Condition, NamesAreDistinct) {
  for (const Condition a : all_conditions) {
    for (const Condition b : all_conditions) EXPECT_EQ(a == b, to_string(a) == to_string(b));
  }
}

TEST(Condition, OnlyTheInitialSetMayTouchTheBoundary) {
  for (const Condition condition : all_conditions) {
    EXPECT_EQ(allows_zero(condition), condition == Condition::initial);
    EXPECT_EQ(is_violated(condition, 0.0), condition != Condition::initial);
    EXPECT_TRUE(is_violated(condition, std::nan("")));
    EXPECT_TRUE(is_violated(condition, 1e-300));
    EXPECT_FALSE(is_violated(condition, -1e-300));
    EXPECT_FALSE(is_violated(condition, kNever));
  }
}

TEST(Residuals, MatchClosedFormsWhereTheConditionsApply) {
  const Networks networks = simple_networks();
  RandomStream random(3, "test");
  Points x(500, 2);
  for (double& value : x.reshaped()) value = random.uniform(-1.0, 1.0);
  x.row(0) << 0.5, 0.55;    // unsafe
  x.row(1) << -0.5, -0.45;  // initial
  x.row(2) << 0.96, 0.1;    // margin
  x.row(3) << 0.1, 0.21;    // band
  const double level_band = 0.1;
  const SafetyProblem problem = simple_problem();
  const Points all = residuals(networks, problem, level_band, x);
  std::array<int, condition_count> applied{};
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const double x1 = x(i, 0), x2 = x(i, 1);
    const double b = x1 + 2 * x2 - 0.5;
    const double b_dot = (-x1 + 2 * x2) + 2 * (-2 * x1 - x2);
    const auto expect = [&](Condition condition, bool applies, double value) {
      const double found = at(all, i, condition);
      if (applies) {
        EXPECT_NEAR(found, value, 1e-12) << to_string(condition);
        ++applied[static_cast<std::size_t>(condition)];
      } else {
        EXPECT_EQ(found, kNever) << to_string(condition);
      }
    };
    expect(Condition::lyapunov_positive, true, -1.5 * x.row(i).squaredNorm());
    expect(Condition::lyapunov_decrease, true, -3.0 * x.row(i).squaredNorm());
    expect(Condition::initial, std::hypot(x1 + 0.5, x2 + 0.5) <= 0.1, b);
    expect(Condition::unsafe, std::hypot(x1 - 0.5, x2 - 0.5) <= 0.2, -b);
    expect(Condition::containment, std::max(std::abs(x1), std::abs(x2)) >= 0.95, -b);
    expect(Condition::barrier_decrease, std::abs(b) <= level_band, b_dot);
  }
  for (const int count : applied) EXPECT_GT(count, 0);
}

TEST(Residuals, OfOneConditionAreItsColumn) {
  const Networks networks = simple_networks();
  const SafetyProblem problem = simple_problem();
  RandomStream random(4, "test");
  Points x(300, 2);
  for (double& value : x.reshaped()) value = random.uniform(-1.0, 1.0);
  const Points all = residuals(networks, problem, 0.2, x);
  for (const Condition condition : all_conditions) {
    const Vector alone = residual(condition, networks, problem, 0.2, x);
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      const double expected = at(all, i, condition);
      if (expected == kNever) {
        EXPECT_EQ(alone[i], kNever);
      } else {
        EXPECT_NEAR(alone[i], expected, 1e-12);
      }
    }
  }
}

TEST(Residuals, AskNothingOfTheGoalButTheBarrier) {
  const Points all = residuals(simple_networks(), simple_problem(), 1.0, Points::Zero(1, 2));
  EXPECT_EQ(at(all, 0, Condition::lyapunov_positive), kNever);
  EXPECT_EQ(at(all, 0, Condition::lyapunov_decrease), kNever);
  EXPECT_EQ(at(all, 0, Condition::barrier_decrease), 0.0);
  const Points near = residuals(simple_networks(), simple_problem(), 1.0, Points{{1e-150, 0.0}});
  EXPECT_TRUE(at(near, 0, Condition::lyapunov_positive) < 0.0);
}

TEST(Residuals, AskNothingOutsideTheWorkspace) {
  const Points all = residuals(simple_networks(), simple_problem(), 10.0, Points{{1.001, 0.0}, {0.0, -7.0}});
  EXPECT_TRUE((all.array() == kNever).all());
}

TEST(Residuals, DoWithoutShellAndObstacle) {
  SafetyProblem problem = simple_problem();
  problem.workspace_margin = nullptr;
  problem.unsafe = empty_region(2);
  const Points all = residuals(simple_networks(), problem, 0.1, Points{{0.99, 0.0}, {0.5, 0.5}});
  EXPECT_TRUE((all.col(static_cast<Eigen::Index>(Condition::containment)).array() == kNever).all());
  EXPECT_TRUE((all.col(static_cast<Eigen::Index>(Condition::unsafe)).array() == kNever).all());
}

TEST(Residuals, OverflowIsAViolation) {
  Networks networks = simple_networks();
  // Finite weights, and yet inf - inf or (where products are fused into sums) inf of either sign.
  networks.V = {.layers = {{.weight = Points{{1e200, 0.0}, {1e200, 0.0}}, .bias = {}},
                           {.weight = Points{{1e200, -1e200}}, .bias = {}}}};
  const Points x{{0.5, 0.5}};
  for (const Condition condition : {Condition::lyapunov_positive, Condition::lyapunov_decrease}) {
    EXPECT_TRUE(is_violated(condition, residual(condition, networks, simple_problem(), 0.1, x)[0]));
  }
  networks = simple_networks();
  networks.B = {.layers = {{.weight = Points{{1e200, 0.0}, {1e200, 0.0}}, .bias = {}},
                           {.weight = Points{{1e200, -1e200}}, .bias = {}}}};
  // A barrier without a value counts as within the band.
  for (const Condition condition : {Condition::unsafe, Condition::barrier_decrease}) {
    EXPECT_TRUE(is_violated(condition, residual(condition, networks, simple_problem(), 0.1, x)[0]));
  }
}

TEST(Residuals, RefuseAnotherDimensionAndABadBand) {
  EXPECT_THROW(residuals(simple_networks(), simple_problem(), 0.1, Points::Zero(1, 3)), Error);
  EXPECT_THROW(residuals(simple_networks(), simple_problem(), -0.1, Points::Zero(1, 2)), Error);
  EXPECT_THROW(residuals(simple_networks(), simple_problem(), std::nan(""), Points::Zero(1, 2)), Error);
}

}  // namespace
}  // namespace s2nnds
