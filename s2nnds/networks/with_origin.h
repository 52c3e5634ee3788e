// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <torch/types.h>

#include <cstdint>

namespace s2nnds {

// x [N, n] -> [N + 1, n]: the origin as one more row, so that less_origin(network(with_origin(x))) is
// N(x) - N(0) in one pass through the network.
inline torch::Tensor with_origin(const torch::Tensor& x) {
  return torch::cat({x, torch::zeros({1, x.size(1)}, x.options())});
}
// values [N + 1, m] -> [N, m]: every row but the last minus the last.
inline torch::Tensor less_origin(const torch::Tensor& values) {
  const std::int64_t samples = values.size(0) - 1;
  return values.narrow(0, 0, samples) - values.narrow(0, samples, 1);
}

}  // namespace s2nnds
