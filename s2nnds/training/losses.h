#pragma once

#include <torch/torch.h>

#include "s2nnds/networks/barrier.h"
#include "s2nnds/networks/lyapunov.h"
#include "s2nnds/networks/vector_field.h"
#include "s2nnds/training/batch.h"
#include "s2nnds/training/trainer_options.h"

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

// mean over samples of |f(x) - xdot|^2, the paper's (6).
torch::Tensor imitation_loss(const torch::Tensor& predicted, const torch::Tensor& velocity);

// The loss of LossOptions on one batch.
LossValue joint_loss(Modules& networks, const BatchTensors& batch, const LossOptions& options);

}  // namespace s2nnds
