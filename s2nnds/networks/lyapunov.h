// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/mlp.h"

namespace s2nnds {

// The module of LyapunovOptions, which has the formulas.
class LyapunovImpl : public torch::nn::Module {
 public:
  LyapunovImpl(std::int64_t dimension, const LyapunovOptions& options, RandomStream& random,
               torch::Dtype dtype = torch::kFloat32);
  torch::Tensor forward(const torch::Tensor& x);  // [N, n] -> [N]
  NetworkWeights snapshot() const;
  void restore(const NetworkWeights& stack);  // throws Error if the shapes differ

  Mlp network{nullptr};

 private:
  bool squared_;
  double quadratic_;
};
TORCH_MODULE(Lyapunov);

}  // namespace s2nnds
