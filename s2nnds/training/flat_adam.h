// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace s2nnds {

// AdamW (Loshchilov, Hutter 2019: weight decay apart from the gradient) of one flat parameter, with the
// gradient clipped to norm 1, in one pass over memory: torch::optim::AdamW and clip_grad_norm_ take some 25
// small operations for it, as long as the gradient itself of networks this small. Same formulas and defaults
// (betas 0.9 and 0.999, epsilon 1e-8).
class FlatAdam {
 public:
  // `weight_decay` >= 0: in a step every parameter loses rate * weight_decay of itself.
  explicit FlatAdam(double weight_decay) : weight_decay_(weight_decay) {}

  // One step from `gradient` [count]; count is the same in every call.
  void step(double rate, std::ptrdiff_t count, const float* gradient, float* parameter);

 private:
  double weight_decay_;
  long steps_ = 0;
  std::vector<float> mean_, square_;  // of the gradient, falling averages
};

}  // namespace s2nnds
