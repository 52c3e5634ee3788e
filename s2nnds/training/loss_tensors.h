// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <torch/torch.h>

#include "s2nnds/training/loss_part.h"

namespace s2nnds {

// The quantities of a set's N samples; undefined where nothing asks for them.
struct SampleTensors {
  torch::Tensor beside;              // [N, n]: the demonstrations' velocities, the boundary's normals
  torch::Tensor f;                   // [N, n]
  torch::Tensor V, V_dot, B, B_dot;  // [N]
};

}  // namespace s2nnds
