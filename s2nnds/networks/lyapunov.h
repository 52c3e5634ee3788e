// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/networks/mlp.h"

namespace s2nnds {

// The module of LyapunovOptions, which has the formulas.
class LyapunovImpl : public torch::nn::Module {
 public:
  // Random weights; throws Error for the scalar form with biases. dtype: torch::kFloat32 or kFloat64.
  LyapunovImpl(std::int64_t dimension, const LyapunovOptions& options, RandomStream& random,
               torch::Dtype dtype = torch::kFloat32);
  torch::Tensor forward(const torch::Tensor& x);  // [N, n] -> [N]
  NetworkWeights snapshot() const;                // the weights as doubles
  void restore(const NetworkWeights& stack);      // throws Error if head or shapes differ

  Mlp network{nullptr};  // phi, n -> features; scalar form: n -> 1

 private:
  bool squared_;
  double quadratic_;
};
// Holds a LyapunovImpl; copies share it.
TORCH_MODULE(Lyapunov);

}  // namespace s2nnds
