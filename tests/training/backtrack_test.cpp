// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/backtrack.h"

#include <gtest/gtest.h>

namespace s2nnds {
namespace {

NetworkWeights affine(const Points& weight, const Vector& bias) {
  return {.layers = {{.weight = weight, .bias = bias, .activation = Activation::identity}}};
}

// Circles about the origin: an exact inverse of time is the same circle.
TEST(Backtrack, FollowsMotionsBackToTheEdgeOfTheBox) {
  const NetworkWeights rotation = affine(Points{{0.0, -3.0}, {3.0, 0.0}}, Vector::Zero(2));
  Points ends(2, 2);
  ends << 0.5, 0.0, 0.0, 0.9;
  const Box box = {Vector{{-0.8, -1.0}}, Vector{{0.8, 1.0}}};
  const std::vector<Points> motions = motions_to(rotation, ends, box, 0.01);
  ASSERT_EQ(motions.size(), 2U);
  for (std::size_t i : {0, 1}) {
    EXPECT_EQ(motions[i].row(0), ends.row(static_cast<Eigen::Index>(i)));
    const Vector radius = motions[i].rowwise().norm();
    EXPECT_LT((radius.array() - radius[0]).abs().maxCoeff(), 1e-3);
    const Points steps =
        motions[i].bottomRows(motions[i].rows() - 1) - motions[i].topRows(motions[i].rows() - 1);
    EXPECT_LT((steps.rowwise().norm().array() - 0.01).abs().maxCoeff(), 1e-5);
  }
  EXPECT_LT(motions[0](1, 1), 0.0) << "backwards is clockwise";
  EXPECT_NEAR(0.01 * static_cast<double>(motions[0].rows() - 1), 4.0 * box.half_widths().norm(), 0.02);
  EXPECT_NEAR(motions[1](motions[1].rows() - 1, 0), 0.8, 0.01) << "it left through the side x = .8";
}

// f = (1, 0), so Bdot = 1 wherever B = x1 rises through 0. X0 is at the left, below x2 = 0.
TEST(Backtrack, LeadsMotionsFromX0ElsewhereAndRaisesBAlongTheOthers) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = box_region({Vector{{-0.9, -0.6}}, Vector{{-0.7, -0.1}}});
  const Networks networks = {affine(Points::Zero(2, 2), Vector{{1.0, 0.0}}),
                             affine(Points{{1.0, 0.0}}, Vector{{0.0}}),
                             affine(Points{{1.0, 0.0}}, Vector{{0.0}})};
  Points found(4, 2), position(2, 2), velocity(2, 2);
  found << 0.0, -0.8,  // dropped: only two are followed
      0.0, -0.4,       // from X0
      0.5, 0.3,        // no longer near {B = 0}
      0.0, 0.3;        // from the workspace's edge
  position << -0.8, -0.4, 0.0, -0.5;
  velocity << 0.2, -0.3, 0.7, 0.1;
  const Backtracked all = backtrack(networks, problem, found, position, velocity,
                                    {.motions = 2, .level_band = 0.01, .gain = 3.0});
  ASSERT_GT(all.upstream.rows(), 90);
  EXPECT_LT((all.upstream.col(1).array() - 0.3).abs().maxCoeff(), 1e-6);
  EXPECT_NEAR(all.upstream.col(0).minCoeff(), -1.0, 0.011);
  EXPECT_EQ(all.upstream.col(0).maxCoeff(), 0.0);
  ASSERT_GT(all.position.rows(), 90);
  EXPECT_LT((all.position.col(1).array() + 0.4).abs().maxCoeff(), 1e-6);
  for (Eigen::Index i = 0; i < all.position.rows(); ++i) {
    const Eigen::Index nearest = all.position(i, 0) < -0.395 ? 0 : 1;
    const Vector expected = velocity.row(nearest) + 3.0 * (position.row(nearest) - all.position.row(i));
    EXPECT_LT((all.velocity.row(i).transpose() - expected).norm(), 1e-12) << all.position.row(i);
  }

  const Backtracked none = backtrack(networks, problem, found, position, velocity, {.motions = 0});
  EXPECT_EQ(none.upstream.rows() + none.position.rows(), 0);
}

// Where f points the other way, nothing is entered.
TEST(Backtrack, LeavesWhatIsNoViolation) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = box_region({Vector{{-0.9, -0.6}}, Vector{{-0.7, -0.1}}});
  const NetworkWeights one = affine(Points{{1.0, 0.0}}, Vector{{0.0}});
  const Networks networks = {affine(Points::Zero(2, 2), Vector{{-1.0, 0.0}}), one, one};
  const Points at = Points::Zero(1, 2);
  const Backtracked all = backtrack(networks, problem, at, at, at, {.level_band = 0.01});
  EXPECT_EQ(all.upstream.rows() + all.position.rows(), 0);
}

}  // namespace
}  // namespace s2nnds
