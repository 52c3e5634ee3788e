// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/networks/mlp.h"

namespace s2nnds {

// The module of LyapunovOptions, which has the formulas.
class LyapunovImpl : public torch::nn::Module {
 public:
  // Random weights; throws Error for the scalar form with biases, and for a diffeomorphism of silu, whose slope
  // exceeds 1. The form auto counts as squared_norm. dtype: torch::kFloat32 or kFloat64.
  LyapunovImpl(std::int64_t dimension, const LyapunovOptions& options, RandomStream& random,
               torch::Dtype dtype = torch::kFloat32);
  torch::Tensor forward(const torch::Tensor& x);  // [N, n] -> [N]
  NetworkWeights snapshot() const;                // the weights as doubles
  void restore(const NetworkWeights& stack);      // throws Error if head or shapes differ

  Mlp network{nullptr};                // phi, n -> features or n; scalar form: n -> 1
  Head head() const { return head_; }  // what is made of phi
  // Diffeomorphism: the product of the layers' spectral norms that training must keep to, in (0, 1).
  double lipschitz() const { return lipschitz_; }

 private:
  Head head_;
  double quadratic_, lipschitz_;
};
// Holds a LyapunovImpl; copies share it.
TORCH_MODULE(Lyapunov);

}  // namespace s2nnds
