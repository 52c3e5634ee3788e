// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/execution_falsifier.h"

#include <gtest/gtest.h>

#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

constexpr auto kBarrier = static_cast<std::size_t>(Condition::barrier_decrease);

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

TEST(ExecutionFalsifier, FindsNothingWhereTheBarrierCoversTheError) {
  ExecutionFalsifier source({}, 20);
  const Counterexamples found = source.find(simple_networks(), simple_problem(), 0.01, 1, 1);
  EXPECT_EQ(found.total(), 0);
  EXPECT_GT(found.samples[kBarrier], 0);
}

TEST(ExecutionFalsifier, HandsOnPointsNearTheBarrierWhereItDoesNot) {
  ExecutionFalsifier source({}, 20);
  Networks networks = simple_networks();
  source.find(networks, simple_problem(), 0.01, 1, 1);
  networks.f = cancelling_field(1e7);  // another field, another error
  const Counterexamples found = source.find(networks, simple_problem(), 0.01, 1, 1);
  ASSERT_GT(found.counts[kBarrier], 0);
  ASSERT_EQ(found.points[kBarrier].rows(), 20);
  const Points value = networks.B.value(found.points[kBarrier]);
  EXPECT_LT(value.cwiseAbs().maxCoeff(), 0.5);
  const Counterexamples again = ExecutionFalsifier({}, 20).find(networks, simple_problem(), 0.01, 1, 1);
  EXPECT_EQ(again.points[kBarrier], found.points[kBarrier]);
}

// On {B = 0} of the hand-made system |f| is below 1: a robot that errs by more can leave.
TEST(ExecutionFalsifier, AsksForWhatTheRobotNeeds) {
  ExecutionFalsifier small({.velocity_error = 0.1}, 20), large({.velocity_error = 2.0}, 20);
  EXPECT_EQ(small.find(simple_networks(), simple_problem(), 0.01, 1, 1).total(), 0);
  const Counterexamples found = large.find(simple_networks(), simple_problem(), 0.01, 1, 1);
  EXPECT_GT(found.counts[kBarrier], 0);
  EXPECT_EQ(found.points[kBarrier].rows(), 20);
}

}  // namespace
}  // namespace s2nnds
