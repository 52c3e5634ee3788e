// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/funnel.h"

#include <gtest/gtest.h>

#include <cmath>

namespace s2nnds {
namespace {

// From (1, height) to (0, height), with velocity `way` times 1 in x.
Demonstration level(double height, double way = -1.0) {
  constexpr Eigen::Index kSamples = 201;
  Demonstration d;
  d.time = Vector::LinSpaced(kSamples, 0.0, 1.0);
  d.position.resize(kSamples, 2);
  d.velocity.resize(kSamples, 2);
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    d.position.row(i) << (way < 0.0 ? 1.0 - d.time[i] : d.time[i]), height;
    d.velocity.row(i) << way, 0.0;
  }
  return d;
}

SafetyProblem problem_with(RegionPtr unsafe) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 2.0);
  problem.unsafe = std::move(unsafe);
  return problem;
}

VelocityTargets samples(const SafetyProblem& problem, const std::vector<Demonstration>& shown,
                        std::int64_t count = 1000) {
  RandomStream random(0, "test");
  return funnel_samples(problem, shown, count, random);
}

TEST(Funnel, LeadsAlongTheDemonstrationAndTowardsIt) {
  const VelocityTargets beside = samples(problem_with(empty_region(2)), {level(0.0)});
  ASSERT_GT(beside.position.rows(), 500);
  for (Eigen::Index i = 0; i < beside.position.rows(); ++i) {
    const double away = beside.position(i, 1);
    EXPECT_LE(std::abs(away), 0.3);
    EXPECT_NEAR(beside.velocity.row(i).norm(), 1.0, 1e-12);  // as fast as the demonstration
    EXPECT_LT(beside.velocity(i, 0), 0.0);
    EXPECT_NEAR(beside.velocity(i, 1) / beside.velocity(i, 0), 2.0 * away, 0.02);
    EXPECT_GE(beside.position.row(i).norm(), 2.0 * std::abs(away) - 1e-9);  // not about the goal
  }
}

TEST(Funnel, IsSilentBetweenMotionsThatGoOtherWays) {
  const VelocityTargets beside = samples(problem_with(empty_region(2)), {level(0.5), level(1.0, 1.0)});
  ASSERT_GT(beside.position.rows(), 100);
  for (Eigen::Index i = 0; i < beside.position.rows(); ++i) {
    const double low = std::abs(beside.position(i, 1) - 0.5), high = std::abs(beside.position(i, 1) - 1.0);
    EXPECT_GT(std::max(low, high), 1.5 * std::min(low, high) - 0.01);
    EXPECT_EQ(beside.velocity(i, 0) < 0.0, low < high);
  }
}

TEST(Funnel, LeadsNeitherOutOfNorThroughTheUnsafeSet) {
  const RegionPtr wall =
      box_region(Box{(Vector(2) << 0.4, 0.1).finished(), (Vector(2) << 0.6, 0.15).finished()});
  const VelocityTargets beside = samples(problem_with(wall), {level(0.0)});
  ASSERT_GT(beside.position.rows(), 100);
  for (Eigen::Index i = 0; i < beside.position.rows(); ++i) {
    const bool is_behind = beside.position(i, 1) >= 0.1;
    EXPECT_FALSE(is_behind && std::abs(beside.position(i, 0) - 0.5) < 0.09);
  }
}

TEST(Funnel, HasNoSamplesWithoutDemonstrationsOrWhereNoneAreWanted) {
  const SafetyProblem problem = problem_with(empty_region(2));
  EXPECT_EQ(samples(problem, {}).position.rows(), 0);
  EXPECT_EQ(samples(problem, {level(0.0)}, 0).position.rows(), 0);
}

}  // namespace
}  // namespace s2nnds
