// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/lyapunov.h"

#include "s2nnds/core/check.h"
#include "s2nnds/networks/with_origin.h"

namespace s2nnds {

LyapunovImpl::LyapunovImpl(std::int64_t dimension, const LyapunovOptions& options, RandomStream& random,
                           torch::Dtype dtype)
    : squared_(options.form == "squared_norm"), quadratic_(squared_ ? options.quadratic : 0.0) {
  check(squared_ || !options.network.bias,
        "networks.V: V(0) = 0 needs form = \"squared_norm\" or bias = false");
  network = register_module("network",
                            Mlp(dimension, squared_ ? options.features : 1, options.network, random, dtype));
}

torch::Tensor LyapunovImpl::forward(const torch::Tensor& x) {
  if (!squared_) return network(x).squeeze(1);
  return less_origin(network(with_origin(x))).square().sum(1) + quadratic_ * x.square().sum(1);
}

NetworkWeights LyapunovImpl::snapshot() const {
  return {network->layers(), squared_ ? Head::squared_norm : Head::plain, quadratic_};
}

void LyapunovImpl::restore(const NetworkWeights& stack) {
  check(stack.head == (squared_ ? Head::squared_norm : Head::plain) && stack.quadratic == quadratic_,
        "networks.V: found head {} with quadratic {}, expected {} with {}", to_string(stack.head),
        stack.quadratic, squared_ ? "squared_norm" : "plain", quadratic_);
  network->set_layers(stack.layers);
}

}  // namespace s2nnds
