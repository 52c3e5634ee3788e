#include "s2nnds/networks/vector_field.h"

#include "s2nnds/core/check.h"
#include "s2nnds/networks/with_origin.h"

namespace s2nnds {

VectorFieldImpl::VectorFieldImpl(std::int64_t dimension, const VectorFieldOptions& options,
                                 RandomStream& random, torch::Dtype dtype)
    : anchored_(options.anchored) {
  check(anchored_ || !options.network.bias, "networks.f: f(0) = 0 needs anchored = true or bias = false");
  network = register_module("network", Mlp(dimension, dimension, options.network, random, dtype));
}

torch::Tensor VectorFieldImpl::forward(const torch::Tensor& x) {
  if (!anchored_) return network(x);
  return less_origin(network(with_origin(x)));
}

LayerStack VectorFieldImpl::snapshot() const {
  return {network->layers(), anchored_ ? Head::anchored : Head::plain, 0.0};
}

void VectorFieldImpl::restore(const LayerStack& stack) {
  check(stack.head == (anchored_ ? Head::anchored : Head::plain), "networks.f: found head {}, expected {}",
        to_string(stack.head), anchored_ ? "anchored" : "plain");
  network->set_layers(stack.layers);
}

}  // namespace s2nnds
