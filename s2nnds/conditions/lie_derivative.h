#pragma once

#include <torch/torch.h>

#include "s2nnds/networks/mlp.h"

namespace s2nnds {

struct LieDerivative {
  torch::Tensor value;       // W(x), [N]
  torch::Tensor derivative;  // grad W(x) . direction, [N]
};

// The value of a scalar network W (a Lyapunov or barrier module) and its derivative along `direction` [N, n],
// which is f(x) for the Lie derivative. Differentiable in the weights of W and in the direction. The engine
// of W decides how: fused, or autograd (grad W with create_graph, so that a loss on it needs a double
// backward).
template <typename Network>
LieDerivative lie_derivative(Network& network, const torch::Tensor& x, const torch::Tensor& direction) {
  if (network->network->engine == Engine::fused) {
    auto [value, derivative] = network->forward_tangent(x, direction);
    return {value, derivative};
  }
  const torch::Tensor point = x.detach().requires_grad_(true);
  const torch::Tensor value = network->forward(point);
  const torch::Tensor gradient = torch::autograd::grad({value.sum()}, {point}, {}, true, true)[0];
  return {value, (gradient * direction).sum(1)};
}

}  // namespace s2nnds
