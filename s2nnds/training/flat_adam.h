#pragma once

#include <torch/torch.h>

#include <vector>

namespace s2nnds {

// AdamW (Loshchilov, Hutter 2019: weight decay apart from the gradient) of one flat parameter, with the gradient clipped
// to a norm, in one pass over memory: torch::optim::AdamW and clip_grad_norm_ take some 25 small operations for it, as
// long as the gradient itself of networks this small. Same formulas and defaults (betas 0.9 and 0.999, epsilon 1e-8).
class FlatAdam {
 public:
  // parameter: [count], contiguous, float32 or float64. Throws Error otherwise.
  FlatAdam(torch::Tensor parameter, double weight_decay, double clip);

  void step(double rate);  // with the gradient that the parameter holds
  void zero_grad();

 private:
  template <typename T>
  void update(double rate);

  torch::Tensor parameter_;
  double weight_decay_, clip_;
  std::int64_t steps_ = 0;
  torch::Tensor mean_, square_;
};

}  // namespace s2nnds
