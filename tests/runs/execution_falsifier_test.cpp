// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/execution_falsifier.h"

#include <gtest/gtest.h>

#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

constexpr auto kBarrier = static_cast<std::size_t>(Condition::barrier_decrease);

// On {B = 0} of the hand-made system |f| is below 1: a robot that errs by more can leave.
TEST(ExecutionFalsifier, AsksForWhatTheRobotNeeds) {
  ExecutionFalsifier small({.velocity_error = 0.1}, 20), large({.velocity_error = 2.0}, 20);
  EXPECT_EQ(small.find(simple_networks(), simple_problem(), 0.01, 1, 1).total(), 0);
  const Counterexamples found = large.find(simple_networks(), simple_problem(), 0.01, 1, 1);
  EXPECT_GT(found.counts[kBarrier], 0);
  ASSERT_EQ(found.points[kBarrier].rows(), 20);
  EXPECT_LT(simple_networks().B.value(found.points[kBarrier]).cwiseAbs().maxCoeff(), 0.5);
}

}  // namespace
}  // namespace s2nnds
