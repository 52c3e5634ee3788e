// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "s2nnds/training/loss_tensors.h"

namespace s2nnds {

// w relu(Bdot + margin_barrier_decrease), w = exp(-(B / band_width)^2) held constant: around {B = 0}. If w
// trained, B would move away from zero instead of falling there.
struct BarrierDecreasePenalty {
  static constexpr Quantities needs{.B = true, .B_dot = true};
  static constexpr Quantities constant{.B = true};

  static torch::Tensor values(const LossOptions& o, const SampleTensors& at) {
    return torch::exp(-(at.B / o.band_width).square()) * torch::relu(at.B_dot + o.margin_barrier_decrease);
  }

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
  static constexpr Quantities needs{.B_dot = true};

  static torch::Tensor values(const LossOptions& o, const SampleTensors& at) {
    return torch::leaky_relu(at.B_dot - o.margin_barrier_decrease, o.leak);
  }

  template <typename T>
  static double value(const LossOptions& o, double weight, const Sample<T>& at) {
    const Rectified penalty = rectified(at.B_dot - o.margin_barrier_decrease, o.leak);
    at.by_B_dot += weight * penalty.slope;
    return penalty.value;
  }
};

}  // namespace s2nnds
