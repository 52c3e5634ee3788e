// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "s2nnds/training/loss_tensors.h"

namespace s2nnds {

// w relu(Bdot + margin_barrier_decrease) on X, w = exp(-(B / band_width)^2): it counts around {B = 0}. w is
// held constant: if it trained, B would move away from zero instead of falling there.
struct BarrierDecreasePenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.B = true, .B_dot = true};
  static constexpr Quantities constant{.B = true};  // w

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions& o, const SampleTensors& at) {
    return torch::exp(-(at.B / o.band_width).square()) * torch::relu(at.B_dot + o.margin_barrier_decrease);
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_B_dot.
  template <typename T>
  static double value(const LossOptions& o, double weight, const Sample<T>& at) {
    const double z = at.B_dot + o.margin_barrier_decrease;
    if (z <= 0.0) return 0.0;
    const double nearness = std::exp(-(at.B / o.band_width) * (at.B / o.band_width));
    at.by_B_dot += weight * nearness;
    return nearness * z;
  }
};

// The paper's (8) as printed: LR(Bdot - margin_barrier_decrease) on all of X.
struct PaperBarrierDecreasePenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.B_dot = true};

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions& o, const SampleTensors& at) {
    return torch::leaky_relu(at.B_dot - o.margin_barrier_decrease, o.leak);
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_B_dot.
  template <typename T>
  static double value(const LossOptions& o, double weight, const Sample<T>& at) {
    const Rectified penalty = rectified(at.B_dot - o.margin_barrier_decrease, o.leak);
    at.by_B_dot += weight * penalty.slope;
    return penalty.value;
  }
};

}  // namespace s2nnds
