// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/mlp.h"

namespace s2nnds {

// The module of VectorFieldOptions, which has the formulas.
class VectorFieldImpl : public torch::nn::Module {
 public:
  VectorFieldImpl(std::int64_t dimension, const VectorFieldOptions& options, RandomStream& random,
                  torch::Dtype dtype = torch::kFloat32);
  torch::Tensor forward(const torch::Tensor& x);  // [N, n] -> [N, n]
  NetworkWeights snapshot() const;
  void restore(const NetworkWeights& stack);  // throws Error if the shapes differ

  Mlp network{nullptr};

 private:
  bool zero_at_origin_;
};
TORCH_MODULE(VectorField);

}  // namespace s2nnds
