// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/training/loss_tensors.h"

namespace s2nnds {

// LR(B + margin_initial) on X0, LR the leaky ReLU (relu where leak = 0).
struct InitialPenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.B = true};

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions& o, const SampleTensors& at) {
    return torch::leaky_relu(at.B + o.margin_initial, o.leak);
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_B.
  template <typename T>
  static double value(const LossOptions& o, double weight, const Sample<T>& at) {
    const Rectified penalty = rectified(at.B + o.margin_initial, o.leak);
    at.by_B += weight * penalty.slope;
    return penalty.value;
  }
};

// LR(margin_unsafe - B) on Xu and the workspace's margin.
struct UnsafePenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.B = true};

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions& o, const SampleTensors& at) {
    return torch::leaky_relu(o.margin_unsafe - at.B, o.leak);
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_B.
  template <typename T>
  static double value(const LossOptions& o, double weight, const Sample<T>& at) {
    const Rectified penalty = rectified(o.margin_unsafe - at.B, o.leak);
    at.by_B -= weight * penalty.slope;
    return penalty.value;
  }
};

}  // namespace s2nnds
