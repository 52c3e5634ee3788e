// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/orientation_law.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/data/orientation.h"

namespace s2nnds {
namespace {

class OrientationLawTest : public testing::Test {
 protected:
  OrientationLawTest() {
    const auto draw = [&] { return random_.normal(); };
    Layer hidden{Points::NullaryExpr(12, 3, draw), Vector::NullaryExpr(12, draw), Activation::tanh};
    Layer output{Points::NullaryExpr(3, 12, draw) / 12.0, {}, Activation::identity};
    law_.psi.layers = {hidden, output};
    law_.psi.head = Head::zero_at_origin;
    law_.rate = 1.3;
    law_.initial_error = 0.5;
    goal_ = quaternion_of({0.7, -1.9, 0.4});
  }

  RandomStream random_{5, "orientation-law-test"};
  OrientationLaw law_;
  Eigen::Vector4d goal_;
};

// The law integrated by small turns with its own angular velocity is the solution in closed form.
TEST_F(OrientationLawTest, TurningAsCommandedIsWhatFollowTells) {
  const Eigen::RowVector3d start(0.9, -0.5, 0.7);
  Eigen::Vector4d q = product(goal_, quaternion_of({0.4, 0.9, -0.6}));
  constexpr int steps = 4000;
  constexpr double h = 2.0 / steps;
  Vector time(steps + 1);
  Points z(steps + 1, 3);
  for (int i = 0; i <= steps; ++i) {
    time[i] = 10.0 + i * h;
    z.row(i) = std::exp(-i * h) * start;  // zdot = -z
  }
  const Points expected = law_.follow(goal_, time, z, q);
  EXPECT_LE(angle_between(expected.row(0).transpose(), q), 1e-12);
  for (int i = 0; i < steps; ++i) {
    const auto omega = [&](double share, const Eigen::Vector4d& at) {
      const Points place = std::exp(-(i + share) * h) * start;
      return Eigen::Vector3d(law_.angular_velocity(goal_, place, -place, at.transpose()).row(0).transpose());
    };
    const Eigen::Vector4d middle = product(quaternion_of(0.5 * h * omega(0.0, q)), q);
    q = product(quaternion_of(h * omega(0.5, middle)), q);
  }
  EXPECT_LE(angle_between(expected.bottomRows(1).transpose(), q), 1e-6);
}

TEST_F(OrientationLawTest, RestsAtTheGoalAlone) {
  const Points none = Points::Zero(1, 3);
  EXPECT_LE(law_.angular_velocity(goal_, none, none, goal_.transpose()).norm(), 1e-14);
  EXPECT_LE(law_.angular_velocity(goal_, none, none, -goal_.transpose()).norm(), 1e-14);
}

TEST_F(OrientationLawTest, ChecksItsNumbers) {
  EXPECT_NO_THROW(law_.check(3));
  EXPECT_THROW(law_.check(2), Error);
  OrientationLaw other = law_;
  other.rate = std::nan("");
  EXPECT_THROW(other.check(3), Error);
  other = law_;
  other.initial_error = 3.2;
  EXPECT_THROW(other.check(3), Error);
  other = law_;
  other.psi.head = Head::plain;
  EXPECT_THROW(other.check(3), Error);
  other = law_;
  other.psi.layers[0].weight(0, 0) += 1e-15;
  EXPECT_NE(other.hash(), law_.hash());
}

}  // namespace
}  // namespace s2nnds
