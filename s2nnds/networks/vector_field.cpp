// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/vector_field.h"

#include "s2nnds/core/check.h"
#include "s2nnds/networks/with_origin.h"

namespace s2nnds {

VectorFieldImpl::VectorFieldImpl(std::int64_t dimension, const VectorFieldOptions& options,
                                 RandomStream& random, torch::Dtype dtype)
    : zero_at_origin_(options.zero_at_origin) {
  check(zero_at_origin_ || !options.network.bias,
        "networks.f: f(0) = 0 needs zero_at_origin = true or bias = false");
  network = register_module("network", Mlp(dimension, dimension, options.network, random, dtype));
}

torch::Tensor VectorFieldImpl::forward(const torch::Tensor& x) {
  if (!zero_at_origin_) return network(x);
  return less_origin(network(with_origin(x)));
}

NetworkWeights VectorFieldImpl::snapshot() const {
  return {network->layers(), zero_at_origin_ ? Head::zero_at_origin : Head::plain, 0.0};
}

void VectorFieldImpl::restore(const NetworkWeights& stack) {
  check(stack.head == (zero_at_origin_ ? Head::zero_at_origin : Head::plain),
        "networks.f: found head {}, expected {}", to_string(stack.head),
        zero_at_origin_ ? "zero_at_origin" : "plain");
  network->set_layers(stack.layers);
}

}  // namespace s2nnds
