// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/flat_adam.h"

#include <gtest/gtest.h>
#include <torch/nn/utils/clip_grad.h>
#include <torch/optim/adamw.h>
#include <torch/types.h>

namespace s2nnds {
namespace {

// Against torch::optim::AdamW and clip_grad_norm_, over steps whose gradients are clipped at first and not at
// the end.
TEST(FlatAdam, TakesTheStepsOfTheLibrarys) {
  torch::manual_seed(1);
  const torch::Tensor target = torch::randn({1000}), start = torch::randn({1000});
  torch::Tensor reference = start.clone().requires_grad_(true), ours = start.clone();
  torch::optim::AdamW library({reference}, torch::optim::AdamWOptions(0.03).weight_decay(0.1));
  FlatAdam adam(0.1);
  bool clipped = false, free = false;
  for (int step = 0; step < 300; ++step) {
    const double rate = 0.03 * (1.0 - step / 400.0);
    static_cast<torch::optim::AdamWOptions&>(library.param_groups()[0].options()).lr(rate);
    library.zero_grad();
    (0.05 * (reference - target).square().sum()).backward();
    const torch::Tensor gradient = (0.1 * (ours - target)).contiguous();
    (gradient.norm().item<double>() > 1.0 ? clipped : free) = true;
    torch::nn::utils::clip_grad_norm_({reference}, 1.0);
    library.step();
    adam.step(rate, ours.numel(), gradient.data_ptr<float>(), ours.data_ptr<float>());
  }
  EXPECT_TRUE(clipped && free);
  EXPECT_GT((ours - start).norm().item<double>(), 10.0);
  EXPECT_LT((ours - reference).norm().item<double>(), 1e-3 * (ours - start).norm().item<double>());
}

}  // namespace
}  // namespace s2nnds
