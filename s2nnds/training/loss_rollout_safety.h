// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/training/loss_tensors.h"

namespace s2nnds {

// Less than the margins on X0 and Xu: points with either kind of rollout lie next to each other, and B can
// change its sign between them only so fast.
inline constexpr double kRolloutSafetyMargin = 0.02;

// relu(B + margin) where rollouts are safe.
struct SafeRolloutPenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.B = true};

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions&, const SampleTensors& at) {
    return torch::relu(at.B + kRolloutSafetyMargin);
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_B.
  template <typename T>
  static double value(const LossOptions&, double weight, const Sample<T>& at) {
    const Rectified penalty = rectified(at.B + kRolloutSafetyMargin);
    at.by_B += weight * penalty.slope;
    return penalty.value;
  }
};

// relu(margin - B) where they are not.
struct UnsafeRolloutPenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.B = true};

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions&, const SampleTensors& at) {
    return torch::relu(kRolloutSafetyMargin - at.B);
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_B.
  template <typename T>
  static double value(const LossOptions&, double weight, const Sample<T>& at) {
    const Rectified penalty = rectified(kRolloutSafetyMargin - at.B);
    at.by_B -= weight * penalty.slope;
    return penalty.value;
  }
};

}  // namespace s2nnds
