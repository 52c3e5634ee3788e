#pragma once

#include <torch/torch.h>

#include <memory>
#include <utility>

#include "s2nnds/networks/fused_network.h"

namespace s2nnds {

// FusedNetwork as one torch::autograd::Function: (value, derivative) [N, m] of the network with flat
// parameters `theta` at x [N, n] along `direction` [N, n]. An undefined direction gives an undefined
// derivative. Gradients flow to theta and to the direction; x counts as a constant.
template <typename T>
std::pair<torch::Tensor, torch::Tensor> fused_apply(const std::shared_ptr<FusedNetwork<T>>& network,
                                                    const torch::Tensor& x, const torch::Tensor& direction,
                                                    const torch::Tensor& theta);

}  // namespace s2nnds
