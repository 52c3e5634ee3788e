// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/barrier.h"
#include "s2nnds/networks/lyapunov.h"
#include "s2nnds/networks/vector_field.h"
#include "s2nnds/training/loss_tensors.h"

namespace s2nnds {

// The three networks in training.
struct Modules {
  VectorField f{nullptr};
  Lyapunov V{nullptr};
  Barrier B{nullptr};
};

// A training step's samples as tensors; a set without points may be undefined.
using BatchTensors = BatchOf<torch::Tensor>;

// A step's loss: its terms, each with its weight applied, and their sum, which is differentiable in the
// networks' parameters.
struct LossValue {
  PerTerm<double> terms{};
  torch::Tensor total;
};

// The quantities at a set's samples, of which there must be some. Differentiable in the parameters: the dots by
// torch::autograd::grad with create_graph, so that a loss on them needs a double backward.
SampleTensors quantities_at(Modules& networks, const BatchTensors& batch, Samples set,
                            const Quantities& needs);

// The loss by torch operations and autograd: the reference.
LossValue autograd_loss(Modules& networks, const LossTable& table, const LossOptions& options,
                        const BatchTensors& batch, Trains trains = Trains::all);

}  // namespace s2nnds
