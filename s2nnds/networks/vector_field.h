// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/networks/mlp.h"

namespace s2nnds {

// The module of VectorFieldOptions, which has the formulas.
class VectorFieldImpl : public torch::nn::Module {
 public:
  // Random weights; throws Error for biases without zero_at_origin. dtype: torch::kFloat32 or kFloat64.
  VectorFieldImpl(std::int64_t dimension, const VectorFieldOptions& options, RandomStream& random,
                  torch::Dtype dtype = torch::kFloat32);
  torch::Tensor forward(const torch::Tensor& x);  // [N, n] -> [N, n]
  NetworkWeights snapshot() const;                // the weights as doubles
  void restore(const NetworkWeights& stack);      // throws Error if head or shapes differ

  Mlp network{nullptr};  // g, n -> n

 private:
  bool zero_at_origin_;
};
// Holds a VectorFieldImpl; copies share it.
TORCH_MODULE(VectorField);

}  // namespace s2nnds
