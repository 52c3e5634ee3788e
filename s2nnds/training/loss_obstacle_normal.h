// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/training/loss_tensors.h"

namespace s2nnds {

// Speed away from the obstacle, in units of the fastest demonstration's. That f points outwards at all is
// what counts; a larger margin would push motions away that only pass.
inline constexpr double kObstacleNormalMargin = 0.02;

// relu(margin - n.f(x)) on the obstacle's boundary, n its unit normal outwards.
struct ObstacleNormalPenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.f = true};

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions&, const SampleTensors& at) {
    return torch::relu(kObstacleNormalMargin - (at.f * at.beside).sum(1));
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_f.
  template <typename T>
  static double value(const LossOptions&, double weight, const Sample<T>& at) {
    double leaving = 0.0;
    for (std::ptrdiff_t k = 0; k < at.dimension; ++k)
      leaving += static_cast<double>(at.beside[k]) * static_cast<double>(at.f[k]);
    const Rectified penalty = rectified(kObstacleNormalMargin - leaving);
    for (std::ptrdiff_t k = 0; k < at.dimension; ++k)
      at.by_f[k] += static_cast<T>(-weight * penalty.slope) * at.beside[k];
    return penalty.value;
  }
};

}  // namespace s2nnds
