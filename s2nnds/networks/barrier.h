// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "s2nnds/networks/mlp.h"
#include "s2nnds/problem/box.h"

namespace s2nnds {

// The module of BarrierOptions.
class BarrierImpl : public torch::nn::Module {
 public:
  // Random weights. dtype: torch::kFloat32 or kFloat64.
  BarrierImpl(std::int64_t dimension, const BarrierOptions& options, RandomStream& random,
              torch::Dtype dtype = torch::kFloat32);
  // Makes the first 2 n neurons of the first layer steep along the sides of the box [n], `slope` > 0 in 1 / normalised
  // length: what they take in is 0 on a side and grows outwards. Throws Error without so many neurons or without biases.
  void lay_along(const Box& box, double slope);
  torch::Tensor forward(const torch::Tensor& x);  // [N, n] -> [N]
  NetworkWeights snapshot() const;                // the weights as doubles
  void restore(const NetworkWeights& stack);      // throws Error if head or shapes differ

  Mlp network{nullptr};  // B itself, n -> 1
};
// Holds a BarrierImpl; copies share it.
TORCH_MODULE(Barrier);

}  // namespace s2nnds
