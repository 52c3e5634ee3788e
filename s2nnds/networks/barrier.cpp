// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/barrier.h"

#include "s2nnds/core/check.h"

namespace s2nnds {

BarrierImpl::BarrierImpl(std::int64_t dimension, const BarrierOptions& options, RandomStream& random,
                         torch::Dtype dtype) {
  network = register_module("network", Mlp(dimension, 1, options.network, random, dtype));
}

torch::Tensor BarrierImpl::forward(const torch::Tensor& x) { return network(x).squeeze(1); }

NetworkWeights BarrierImpl::snapshot() const { return {network->layers(), Head::plain, 0.0}; }

void BarrierImpl::restore(const NetworkWeights& stack) {
  check(stack.head == Head::plain, "networks.B: found head {}, expected plain", to_string(stack.head));
  network->set_layers(stack.layers);
}

}  // namespace s2nnds
