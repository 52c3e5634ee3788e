#pragma once

#include <torch/torch.h>

#include "s2nnds/networks/barrier.h"
#include "s2nnds/networks/lyapunov.h"
#include "s2nnds/networks/vector_field.h"
#include "s2nnds/training/trainer_options.h"

namespace s2nnds {

// The three networks in training.
struct Modules {
  VectorField f{nullptr};
  Lyapunov V{nullptr};
  Barrier B{nullptr};
};

// A training step's samples as tensors: [N, n] each; undefined where there are none.
struct BatchTensors {
  torch::Tensor position, velocity, workspace, initial, unsafe, safe, unsafe_rollouts, boundary, normal;
};

// The terms of a step's loss, each with its weight applied. Undefined terms do not apply.
struct LossTerms {
  torch::Tensor mse;  // unweighted
  torch::Tensor lyapunov;
  torch::Tensor barrier_sets;
  torch::Tensor barrier_decrease;
  torch::Tensor rollout_safety;
  torch::Tensor obstacle_normal;
  torch::Tensor total;
};

// mean over samples of |f(x) - xdot|^2, the paper's (6).
torch::Tensor imitation_loss(const torch::Tensor& predicted, const torch::Tensor& velocity);

// The loss of LossOptions on one batch.
LossTerms joint_loss(Modules& networks, const BatchTensors& batch, const LossOptions& options);

}  // namespace s2nnds
