// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <torch/types.h>

#include "s2nnds/training/loss_part.h"

namespace s2nnds {

// The quantities of a set's N samples; undefined where nothing asks for them.
struct SampleTensors {
  torch::Tensor beside;  // [N, n]: the demonstrations' velocities, the boundary's normals
  torch::Tensor f;       // f(x), [N, n]
  torch::Tensor V,       // V(x), [N]
      V_dot,             // grad V(x) . f(x), [N]
      B,                 // B(x), [N]
      B_dot;             // grad B(x) . f(x), [N]
};

}  // namespace s2nnds
