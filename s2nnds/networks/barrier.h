// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/mlp.h"

namespace s2nnds {

// The module of BarrierOptions.
class BarrierImpl : public torch::nn::Module {
 public:
  BarrierImpl(std::int64_t dimension, const BarrierOptions& options, RandomStream& random,
              torch::Dtype dtype = torch::kFloat32);
  torch::Tensor forward(const torch::Tensor& x);  // [N, n] -> [N]
  NetworkWeights snapshot() const;
  void restore(const NetworkWeights& stack);  // throws Error if the shapes differ

  Mlp network{nullptr};
};
TORCH_MODULE(Barrier);

}  // namespace s2nnds
