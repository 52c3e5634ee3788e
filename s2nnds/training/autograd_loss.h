// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/barrier.h"
#include "s2nnds/networks/lyapunov.h"
#include "s2nnds/networks/vector_field.h"
#include "s2nnds/training/loss_tensors.h"

namespace s2nnds {

// The three networks in training, in normalised coordinates. Empty until they are set.
struct Modules {
  VectorField f{nullptr};  // xdot = f(x): [N, n] -> [N, n]
  Lyapunov V{nullptr};     // Lyapunov function: [N, n] -> [N]
  Barrier B{nullptr};      // barrier function, safe where B <= 0: [N, n] -> [N]
};

// The samples of one training step as tensors [N, n]. A set without points may be an undefined tensor.
using BatchTensors = BatchOf<torch::Tensor>;

// The loss of one training step.
struct LossValue {
  PerTerm<double> terms{};  // each with its weight applied
  torch::Tensor total;      // the sum of the terms, a scalar; differentiable in the networks' parameters
};

// The quantities at the samples of one set, which must not be empty. They are differentiable in the
// parameters. The dots come from torch::autograd::grad with create_graph, so a loss on them needs a double
// backward.
SampleTensors quantities_at(Modules& networks, const BatchTensors& batch, Samples set,
                            const Quantities& needs, const LossOptions& options = {});

// The loss by torch operations and autograd, which the fused engine is compared with.
LossValue autograd_loss(Modules& networks, const LossTable& table, const LossOptions& options,
                        const BatchTensors& batch, const Trains& trains = {});

}  // namespace s2nnds
