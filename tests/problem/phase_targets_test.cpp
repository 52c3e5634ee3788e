// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/phase_targets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/extruded_region.h"

namespace s2nnds {
namespace {

// Along the x axis from (-1, 0, 1) to the goal, at constant speed.
Demonstration straight() {
  Demonstration d{Vector::LinSpaced(201, 0, 2), Points::Zero(201, 3), Points::Zero(201, 3)};
  d.position.col(0) = Vector::LinSpaced(201, -1, 0);
  d.position.col(2) = Vector::LinSpaced(201, 1, 0);
  d.velocity.col(0).setConstant(0.5);
  d.velocity.col(2).setConstant(-0.5);
  return d;
}

SafetyProblem problem_with(const RegionPtr& unsafe) {
  SafetyProblem problem;
  problem.workspace = {Vector{{-1.25, -1.25, -0.25}}, Vector{{1.25, 1.25, 1.25}}};
  problem.unsafe = unsafe;
  problem.phase_start = 1.0;
  return problem;
}

TEST(PhaseTargets, LeadToThePathAndRunOut) {
  const SafetyProblem problem = problem_with(empty_region(3));
  RandomStream random(3, "test");
  const VelocityTargets found = phase_targets(problem, {straight()}, 2000, random);
  ASSERT_EQ(found.position.rows(), 2000);
  for (Eigen::Index i = 0; i < 2000; ++i) {
    const double s = found.position(i, 2), rate = found.velocity(i, 2);
    const Eigen::Vector2d off(found.position(i, 0) + std::clamp(s, 0.0, 1.0), found.position(i, 1));
    EXPECT_GT(off.norm(), 0.03);
    // s comes to 0, and the distance from p(s) falls.
    EXPECT_LT(s * rate, 0.0);
    const bool on_the_way = s > 0.01 && s < 0.99;
    const Eigen::Vector2d along(0.5 * std::clamp(10.0 * s, 0.0, 1.0), 0.0);
    const Eigen::Vector2d towards = found.velocity.row(i).head(2).transpose() - along;
    EXPECT_NEAR(towards.norm(), std::min(0.7, 2.0 * off.norm()), 0.02);
    EXPECT_LT(towards.dot(off), 0.0);
    if (on_the_way && s > 0.5) {
      EXPECT_NEAR(rate, -0.5, 1e-9);
    }
  }
}

TEST(PhaseTargets, AreNotBehindAnObstacle) {
  const SafetyProblem problem = problem_with(extruded(ball(Vector{{-0.5, 0.4}}, 0.2)));
  RandomStream random(3, "test");
  const VelocityTargets found = phase_targets(problem, {straight()}, 2000, random);
  EXPECT_GT(found.position.rows(), 1000);
  EXPECT_GT(problem.unsafe->level(found.position).minCoeff(), 0.0);
  for (Eigen::Index i = 0; i < found.position.rows(); ++i) {
    const Eigen::RowVectorXd x = found.position.row(i);
    // Right above the ball, when the path is right below it.
    EXPECT_FALSE(std::abs(x[0] + 0.5) < 0.1 && x[1] > 0.65 && std::abs(x[2] - 0.5) < 0.1) << x;
  }
}

TEST(PhasePath, IsOfDemonstrationsThatAreSafe) {
  Demonstration beside = straight();
  beside.position.col(1).setConstant(0.5);
  const SafetyProblem problem = problem_with(extruded(ball(Vector{{-0.5, 0.0}}, 0.2)));
  const Points path = phase_path(problem, {straight(), beside});
  ASSERT_EQ(path.rows(), 200);
  EXPECT_TRUE(path.row(0).isApprox(Eigen::RowVector3d(-1.0, 0.5, 1.0)));
  EXPECT_TRUE(path.row(199).isApprox(Eigen::RowVector3d(0.0, 0.5, 0.0)));
  for (Eigen::Index i = 1; i < 200; ++i)
    EXPECT_NEAR((path.row(i) - path.row(i - 1)).norm(), std::sqrt(2.0) / 199.0, 1e-6);
}

TEST(PhaseTargets, NeedAPhase) {
  SafetyProblem problem = problem_with(empty_region(3));
  RandomStream random(3, "test");
  EXPECT_THROW(phase_targets(problem, {}, 5, random), Error);
  problem.phase_start = 0.0;
  EXPECT_THROW(phase_targets(problem, {straight()}, 5, random), Error);
  EXPECT_THROW(phase_path(problem, {straight()}), Error);
}

}  // namespace
}  // namespace s2nnds
