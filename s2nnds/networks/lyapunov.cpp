// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/lyapunov.h"

#include "s2nnds/core/check.h"
#include "s2nnds/networks/with_origin.h"

namespace s2nnds {
namespace {

Head head_of(const std::string& form) {
  if (form == "scalar") return Head::plain;
  return form == "diffeomorphism" ? Head::diffeomorphism : Head::squared_norm;
}

}  // namespace

LyapunovImpl::LyapunovImpl(std::int64_t dimension, const LyapunovOptions& options, RandomStream& random,
                           torch::Dtype dtype)
    : head_(head_of(options.form)),
      quadratic_(head_ == Head::squared_norm ? options.quadratic : 0.0),
      lipschitz_(options.lipschitz) {
  check(head_ != Head::plain || !options.network.bias,
        "networks.V: V(0) = 0 needs form = \"squared_norm\" or \"diffeomorphism\", or bias = false");
  check(head_ != Head::diffeomorphism ||
            (options.network.activation != "silu" && options.network.output_activation != "silu"),
        "networks.V: found a diffeomorphism of silu, whose slope exceeds 1; expected another activation");
  const std::int64_t outputs = head_ == Head::squared_norm ? options.features
                               : head_ == Head::plain      ? 1
                                                           : dimension;
  network = register_module("network", Mlp(dimension, outputs, options.network, random, dtype));
}

torch::Tensor LyapunovImpl::forward(const torch::Tensor& x) {
  if (head_ == Head::plain) return network(x).squeeze(1);
  const torch::Tensor features = less_origin(network(with_origin(x)));
  if (head_ == Head::diffeomorphism) return (features + x).square().sum(1);
  return features.square().sum(1) + quadratic_ * x.square().sum(1);
}

NetworkWeights LyapunovImpl::snapshot() const { return {network->layers(), head_, quadratic_}; }

void LyapunovImpl::restore(const NetworkWeights& stack) {
  check(stack.head == head_ && stack.quadratic == quadratic_,
        "networks.V: found head {} with quadratic {}, expected {} with {}", to_string(stack.head),
        stack.quadratic, to_string(head_), quadratic_);
  network->set_layers(stack.layers);
}

}  // namespace s2nnds
