// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/barrier.h"

#include <tuple>

#include "s2nnds/core/check.h"

namespace s2nnds {

BarrierImpl::BarrierImpl(std::int64_t dimension, const BarrierOptions& options, RandomStream& random,
                         torch::Dtype dtype) {
  network = register_module("network", Mlp(dimension, 1, options.network, random, dtype));
}

void BarrierImpl::lay_along(const Box& box, double slope) {
  std::vector<Layer> layers = network->layers();
  Layer& first = layers.front();
  const Eigen::Index n = box.dimension();
  check(first.bias.size() >= 2 * n && first.weight.cols() == n,
        "networks.B: found {} neurons with a bias in the first layer, expected {} for the sides of the "
        "workspace",
        first.bias.size(), 2 * n);
  for (Eigen::Index d = 0; d < n; ++d) {
    for (const auto& [row, sign, side] :
         {std::tuple(2 * d, 1.0, box.upper[d]), {2 * d + 1, -1.0, box.lower[d]}}) {
      first.weight.row(row).setZero();
      first.weight(row, d) = sign * slope;
      first.bias[row] = -sign * slope * side;
    }
  }
  network->set_layers(layers);
}

torch::Tensor BarrierImpl::forward(const torch::Tensor& x) { return network(x).squeeze(1); }

NetworkWeights BarrierImpl::snapshot() const { return {network->layers(), Head::plain, 0.0}; }

void BarrierImpl::restore(const NetworkWeights& stack) {
  check(stack.head == Head::plain, "networks.B: found head {}, expected plain", to_string(stack.head));
  network->set_layers(stack.layers);
}

}  // namespace s2nnds
