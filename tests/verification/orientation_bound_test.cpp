// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/orientation_bound.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/random.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {
namespace {

// psi(x) = a tanh(2 x_0) e_0 + b tanh(x_1) e_1: |psi| is largest at the corners.
OrientationLaw law_of(double a, double b, double initial_error) {
  OrientationLaw law;
  Points in{{2.0, 0.0}, {0.0, 1.0}}, out{{a, 0.0}, {0.0, b}, {0.0, 0.0}};
  law.psi.layers = {{in, Vector::Zero(2), Activation::tanh}, {out, {}, Activation::identity}};
  law.psi.head = Head::zero_at_origin;
  law.initial_error = initial_error;
  return law;
}

class OrientationBoundTest : public testing::Test {
 protected:
  OrientationBoundTest() {
    problem_.workspace = problem_.contained = Box::cube(2, 1.25);
    problem_.initial = problem_.unsafe = empty_region(2);
    // B = |x|^2 - 1/4
    networks_.B.layers = {{Points::Identity(2, 2), {}, Activation::identity}};
    networks_.B.head = Head::squared_norm;
    networks_.f.layers = {{-Points::Identity(2, 2), {}, Activation::identity}};
    networks_.V.layers = {{Points::Identity(2, 2), {}, Activation::identity}};
    networks_.V.head = Head::squared_norm;
  }
  // {B <= 0} is the half plane x_0 <= edge.
  OrientationBound prove(const OrientationLaw& law, double edge) {
    networks_.B = {};
    networks_.B.layers = {{Points{{1.0, 0.0}}, Vector::Constant(1, -edge), Activation::identity}};
    return prove_orientation_bound(law, ProofFunctions::of(networks_), problem_, few_);
  }

  BranchLimits few_ = {.max_boxes = 30000};
  Networks networks_;
  SafetyProblem problem_;
};

TEST_F(OrientationBoundTest, IsProvedUpToTheLargestTurnOnTheSafeSet) {
  const double corner = std::hypot(2.0 * std::tanh(2.5), 1.0 * std::tanh(1.25));
  const OrientationBound found = prove(law_of(2.0, 1.0, 0.5), 10.0);
  EXPECT_TRUE(found.proved) << found.reason;
  EXPECT_GE(found.bound, corner);
  EXPECT_LE(found.bound, 1.03 * corner + 0.011);
  EXPECT_GT(found.boxes, 1);
  // By little more than there is room for.
  EXPECT_TRUE(prove(law_of(2.0, 1.0, M_PI - corner - 1e-3), 10.0).proved);
  EXPECT_FALSE(prove(law_of(2.0, 1.0, M_PI - corner + 1e-3), 10.0).proved);
}

TEST_F(OrientationBoundTest, CountsTheSafeSetAlone) {
  EXPECT_FALSE(prove(law_of(3.5, 0.1, 0.3), 10.0).proved);
  EXPECT_FALSE(prove(law_of(3.5, 0.1, 0.3), 0.9).proved);  // x_0 down to -1.25 is still safe
  OrientationLaw law = law_of(3.5, 0.1, 0.3);
  law.psi.layers[0].weight *= 0.5;
  law.psi.layers[0].weight(0, 0) = 1.0;
  problem_.workspace.lower[0] = -0.4;
  const OrientationBound found = prove(law, 0.4);
  EXPECT_TRUE(found.proved) << found.reason;
  EXPECT_GE(found.bound, 3.5 * std::tanh(0.4));
  EXPECT_LE(found.bound, 3.6 * std::tanh(0.4) + 0.02);
}

TEST_F(OrientationBoundTest, FalseOfWhatIsNoNumberOrTooLarge) {
  OrientationLaw law = law_of(1.0, 1.0, 0.3);
  law.psi.layers[1].weight *= 1e20;
  EXPECT_FALSE(prove(law, 10.0).proved);
  EXPECT_NE(prove(law, 10.0).reason, "");
}

// Every bound that is proved holds at random points, for random laws and barriers.
TEST_F(OrientationBoundTest, HoldsAtRandomPoints) {
  RandomStream random(7, "orientation-bound-test");
  int proved = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const auto draw = [&] { return random.normal(); };
    OrientationLaw law;
    law.psi.layers = {{Points::NullaryExpr(10, 2, draw), Vector::NullaryExpr(10, draw), Activation::tanh},
                      {0.4 * Points::NullaryExpr(3, 10, draw), {}, Activation::identity}};
    law.psi.head = Head::zero_at_origin;
    law.initial_error = 0.2;
    networks_.B.layers = {{Points::NullaryExpr(6, 2, draw), Vector::NullaryExpr(6, draw), Activation::tanh},
                          {Points::NullaryExpr(1, 6, draw), {}, Activation::identity}};
    networks_.B.head = Head::plain;
    const OrientationBound found =
        prove_orientation_bound(law, ProofFunctions::of(networks_), problem_, few_);
    if (!found.proved) continue;
    ++proved;
    const Points x = Points::NullaryExpr(20000, 2, [&] { return random.uniform(-1.25, 1.25); });
    const Points psi = law.psi.value(x), level = networks_.B.value(x);
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      ASSERT_TRUE(level(i, 0) > 0.0 || psi.row(i).norm() < found.bound);
    EXPECT_LT(found.bound + law.initial_error, M_PI);
  }
  EXPECT_GT(proved, 5);
}

}  // namespace
}  // namespace s2nnds
