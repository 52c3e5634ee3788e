// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "s2nnds/training/loss_tensors.h"

namespace s2nnds {

// log(1 + relu(q)) on X, q = Vdot / (V + 1e-6) + decay_rate: how far V's decay rate along motions falls
// short, whatever the scale of V.
struct LyapunovPenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.V = true, .V_dot = true};
  static constexpr double tiny = 1e-6;  // added to V, which is 0 at the goal

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions& o, const SampleTensors& at) {
    return torch::log1p(torch::relu(at.V_dot / (at.V + tiny) + o.decay_rate));
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_V and at.by_V_dot.
  template <typename T>
  static double value(const LossOptions& o, double weight, const Sample<T>& at) {
    const double scale = at.V + tiny, q = at.V_dot / scale + o.decay_rate;
    if (q <= 0.0) return 0.0;
    const double by_V_dot = weight / (1.0 + q) / scale;
    at.by_V_dot += by_V_dot;
    at.by_V += -by_V_dot * at.V_dot / scale;
    return std::log1p(q);
  }
};

// The paper's (7) as printed: LR(margin_positive - V) + LR(Vdot - margin_decrease) on X, LR the leaky ReLU.
struct PaperLyapunovPenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.V = true, .V_dot = true};

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions& o, const SampleTensors& at) {
    return torch::leaky_relu(o.margin_positive - at.V, o.leak) +
           torch::leaky_relu(at.V_dot - o.margin_decrease, o.leak);
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_V and at.by_V_dot.
  template <typename T>
  static double value(const LossOptions& o, double weight, const Sample<T>& at) {
    const Rectified positive = rectified(o.margin_positive - at.V, o.leak);
    const Rectified decrease = rectified(at.V_dot - o.margin_decrease, o.leak);
    at.by_V -= weight * positive.slope;
    at.by_V_dot += weight * decrease.slope;
    return positive.value + decrease.value;
  }
};

}  // namespace s2nnds
