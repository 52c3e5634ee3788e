// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/climb.h"

#include <gtest/gtest.h>

#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/training/band_falsifier.h"

namespace s2nnds {
namespace {

constexpr double kBand = 0.01;

NetworkWeights affine(const Points& weight, const Vector& bias) {
  return {.layers = {{.weight = weight, .bias = bias, .activation = Activation::identity}}};
}

// The obstacle right of 0.25 in [-1, 1]^2.
SafetyProblem half_blocked() {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.unsafe = box_region({Vector{{0.25, -1.0}}, Vector{{1.0, 1.0}}});
  return problem;
}

TEST(Climb, FindsACornerThatFewPointsHit) {
  // B <= 0 in the obstacle's corner alone, a triangle of area 0.00125.
  const Networks networks{{}, {}, affine(Points{{1.0, 1.0}}, Vector{{0.7}})};
  const SafetyProblem problem = half_blocked();
  RandomStream random(1, "climb");
  const Points x = RegionSampler(problem.unsafe, problem.workspace).sample(200, random);
  const Vector rank = -networks.B.value(x).col(0);
  ASSERT_LT(rank.maxCoeff(), 0.0);
  const Counterexamples found = climb(Condition::unsafe, networks, problem, kBand, x, rank, 0.0, random);
  const auto q = static_cast<std::size_t>(Condition::unsafe);
  EXPECT_GT(found.counts[q], 0);
  EXPECT_EQ(found.points[q].rows(), found.counts[q]);
  EXPECT_LE(networks.B.value(found.points[q]).maxCoeff(), 0.0);
  EXPECT_LE(problem.unsafe->level(found.points[q]).maxCoeff(), 0.0);
}

TEST(Climb, HandsOnWhatIsNearlyWrong) {
  const Networks networks{
      {}, {}, affine(Points{{1.0, 1.0}}, Vector{{0.8}})};  // at least 0.05 in the obstacle
  const SafetyProblem problem = half_blocked();
  RandomStream random(1, "climb");
  const Points x = RegionSampler(problem.unsafe, problem.workspace).sample(200, random);
  const Vector rank = -networks.B.value(x).col(0);
  const Counterexamples found = climb(Condition::unsafe, networks, problem, kBand, x, rank, 0.1, random);
  const auto q = static_cast<std::size_t>(Condition::unsafe);
  EXPECT_EQ(found.counts[q], 0);
  EXPECT_GT(found.points[q].rows(), 0);
  EXPECT_LT(networks.B.value(found.points[q]).maxCoeff(), 0.1);
}

TEST(BandFalsifier, FindsWhereTheBarrierRises) {
  // B = x1 - 0.2, Bdot = x2 - 0.95.
  const Networks networks{affine(Points{{0.0, 1.0}, {0.0, 0.0}}, Vector{{-0.95, 0.0}}),
                          {},
                          affine(Points{{1.0, 0.0}}, Vector{{-0.2}})};
  const auto q = static_cast<std::size_t>(Condition::barrier_decrease);
  const Counterexamples found = BandFalsifier(100, 0.0).find(networks, half_blocked(), kBand, 0, 1);
  EXPECT_GT(found.counts[q], 0);
  const Points& x = found.points[q];
  EXPECT_LE((x.col(0).array() - 0.2).abs().maxCoeff(), kBand);
  EXPECT_GE(x.col(1).minCoeff(), 0.95);
}

TEST(BandFalsifier, FindsNothingWhereItFalls) {
  const Networks networks{
      affine(Points::Zero(2, 2), Vector{{-1.0, 0.0}}), {}, affine(Points{{1.0, 0.0}}, Vector{{-0.2}})};
  const Counterexamples found = BandFalsifier(100, 0.05).find(networks, half_blocked(), kBand, 0, 1);
  EXPECT_EQ(found.total(), 0);
  for (const Points& points : found.points) EXPECT_EQ(points.rows(), 0);
}

}  // namespace
}  // namespace s2nnds
