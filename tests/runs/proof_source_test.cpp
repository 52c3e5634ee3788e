// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/proof_source.h"

#include <gtest/gtest.h>

#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

constexpr auto kDecrease = static_cast<std::size_t>(Condition::lyapunov_decrease);
constexpr auto kBarrier = static_cast<std::size_t>(Condition::barrier_decrease);

Counterexamples find(ProofSource& source, const Networks& networks) {
  return source.find(networks, simple_problem(), 0.01, 1, 1);
}

TEST(ProofSource, FindsNothingWhereAllIsProved) {
  ProofSource source(ProofOptions::fail_fast(), 100);
  const Counterexamples found = find(source, simple_networks());
  EXPECT_EQ(found.total(), 0);
  EXPECT_GT(found.samples[kDecrease], 0);
}

TEST(ProofSource, AsksAgainOnlyWhatNetworksThatHaveChangedConcern) {
  ProofSource source(ProofOptions::fail_fast(), 100);
  Networks networks = simple_networks();
  find(source, networks);
  EXPECT_EQ(find(source, networks).samples, decltype(Counterexamples::samples){});
  networks.V.quadratic *= 1.5;
  const Counterexamples again = find(source, networks);
  EXPECT_EQ(again.samples[kBarrier], 0);
  EXPECT_GT(again.samples[kDecrease], 0);
}

// -x as the difference of large numbers, which float32 cannot tell from 0.
NetworkWeights cancelling_field(double size) {
  Points inner(4, 2), outer(2, 4);
  inner << Points::Identity(2, 2), Points::Identity(2, 2);
  outer << size * Points::Identity(2, 2), -(size + 1.0) * Points::Identity(2, 2);
  NetworkWeights f;
  f.layers = {layer(inner, Vector(), Activation::identity), layer(outer, Vector(), Activation::identity)};
  f.head = Head::zero_at_origin;
  return f;
}

TEST(ProofSource, AsksThatTheBarrierCoversTheErrorOfFloat32) {
  ProofSource source(ProofOptions::fail_fast(), 20);
  Networks networks = simple_networks();
  EXPECT_EQ(find(source, networks).total(), 0);
  networks.f = cancelling_field(1e7);  // another field, another error
  const Counterexamples found = find(source, networks);
  ASSERT_GT(found.counts[kBarrier], 0);
  ASSERT_EQ(found.points[kBarrier].rows(), 20);
  EXPECT_LT(networks.B.value(found.points[kBarrier]).cwiseAbs().maxCoeff(), 0.5);
  ProofSource fresh(ProofOptions::fail_fast(), 20);
  EXPECT_EQ(find(fresh, networks).points[kBarrier], found.points[kBarrier]);
}

TEST(ProofSource, DoesNotAskAgainWhetherVDecreasesWhileFAndVStayAsTheyWere) {
  ProofSource source(ProofOptions::fail_fast(), 100);
  Networks networks = simple_networks();
  find(source, networks);
  networks.B.layers.front().weight *= 1.01;
  const Counterexamples same = find(source, networks);
  EXPECT_EQ(same.total(), 0);
  EXPECT_EQ(same.samples[kDecrease], 0);
  EXPECT_GT(same.samples[kBarrier], 0);
  networks.f = linear_field(Points::Identity(2, 2));  // unstable
  networks.B = simple_networks().B;
  networks.B.layers.back().weight *= -1.0;  // fails as well: V is not looked at
  EXPECT_GT(find(source, networks).total(), 0);
  EXPECT_EQ(find(source, networks).samples[kDecrease], 0);
}

TEST(ProofSource, LooksAtVOnceAllElseHolds) {
  ProofSource source(ProofOptions::fail_fast(), 100);
  Networks networks = simple_networks();
  find(source, networks);
  networks.V.layers.front().weight << 1.0, 4.0, 0.0, 0.1;  // |x_1 + 4 x_2|^2 + .01 x_2^2 decreases too
  EXPECT_GT(find(source, networks).samples[kDecrease], 0) << "another V";
}

// Witnesses come first: each violates the condition.
TEST(ProofSource, HandsOnPointsThatViolate) {
  ProofSource source(ProofOptions::fail_fast(), 50);
  Networks networks = simple_networks();
  networks.f = linear_field((Points(2, 2) << -1.0, 0.0, 0.0, 1.0).finished());
  const Counterexamples found = find(source, networks);
  ASSERT_GT(found.counts[kBarrier], 0);
  ASSERT_EQ(found.points[kBarrier].rows(), 50);
  const Points x = found.points[kBarrier].topRows(5);
  Points value, derivative;
  networks.B.value_and_derivative(x, networks.f.value(x), value, derivative);
  EXPECT_GE(derivative.minCoeff(), 0.0);
  EXPECT_LE(value.cwiseAbs().maxCoeff(), 0.01);
}

}  // namespace
}  // namespace s2nnds
