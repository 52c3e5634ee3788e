// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/warm_start.h"

#include <gtest/gtest.h>
#include <torch/utils.h>

#include <algorithm>
#include <cstdint>

namespace s2nnds {
namespace {

// f is fitted to xdot = -x.
class WarmStart : public ::testing::Test {
 protected:
  WarmStartSummary run(const WarmStartOptions& options) {
    const torch::Tensor position = torch::linspace(-1.0, 1.0, 200).view({100, 2});
    const Vector still = Vector::Zero(position.size(0));
    mse_.clear();
    VectorField f = nullptr;
    const WarmStartSummary summary =
        warm_start(f, position, -position, still, options, Engine::fused, 1, [&](std::int64_t attempt) {
          RandomStream random(1, "start", attempt);
          VectorFieldOptions small;
          small.network.hidden = {16};
          const VectorField start(2, small, random);
          mse_.push_back(mse_of(start, position));
          return start;
        });
    EXPECT_NEAR(summary.mse, mse_of(f, position), 1e-6);
    return summary;
  }

  std::vector<double> mse_;  // of the starts

 private:
  static double mse_of(VectorField f, const torch::Tensor& position) {
    torch::NoGradGuard no_grad;
    return (f(position) + position).square().sum(1).mean().item<double>();
  }
};

TEST_F(WarmStart, DrawsStartsThatStallAnewAndKeepsTheBest) {
  WarmStartOptions options;
  options.rate = 1e-12;  // learns nothing
  options.weight_decay = 0.0;
  options.steps = 5;
  options.attempts = 3;
  const WarmStartSummary summary = run(options);
  EXPECT_TRUE(summary.stalled);
  ASSERT_EQ(mse_.size(), 3U);
  const auto best = std::min_element(mse_.begin(), mse_.end());
  EXPECT_EQ(summary.attempt, std::distance(mse_.begin(), best) + 1);
  EXPECT_NEAR(summary.mse, *best, 1e-5);
}

TEST_F(WarmStart, KeepsTheFirstStartThatLearns) {
  WarmStartOptions options;
  options.rate = 1e-2;
  options.steps = 200;
  const WarmStartSummary summary = run(options);
  EXPECT_FALSE(summary.stalled);
  EXPECT_EQ(summary.attempt, 1);
  EXPECT_EQ(mse_.size(), 1U);
  EXPECT_LT(summary.mse, 0.1 * mse_.front());
}

}  // namespace
}  // namespace s2nnds
