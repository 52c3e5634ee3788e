// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/training/loss_tensors.h"

namespace s2nnds {

// |f(x) - xdot|^2 on the demonstrations, the paper's (6).
struct ImitationPenalty {
  // What the penalty is computed from.
  static constexpr Quantities needs{.f = true};

  // The penalties [N], by torch operations.
  static torch::Tensor values(const LossOptions&, const SampleTensors& at) {
    return (at.f - at.beside).square().sum(1);
  }

  // The penalty of one sample; adds weight times its derivatives to at.by_f.
  template <typename T>
  static double value(const LossOptions&, double weight, const Sample<T>& at) {
    double sum = 0.0;
    for (std::ptrdiff_t k = 0; k < at.dimension; ++k) {
      const T error = at.f[k] - at.beside[k];
      sum += static_cast<double>(error) * static_cast<double>(error);
      at.by_f[k] += static_cast<T>(2.0 * weight) * error;
    }
    return sum;
  }
};

}  // namespace s2nnds
