// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/flat_adam.h"

#include <algorithm>
#include <cmath>

namespace s2nnds {
namespace {

constexpr double kClip = 1.0;  // norm of the gradient: no single batch moves the weights far

}  // namespace

void FlatAdam::step(double rate, std::ptrdiff_t count, const float* gradient, float* parameter) {
  constexpr float beta1 = 0.9F, beta2 = 0.999F, epsilon = 1e-8F;
  mean_.resize(static_cast<std::size_t>(count));
  square_.resize(static_cast<std::size_t>(count));
  ++steps_;
  double norm = 0.0;
  for (std::ptrdiff_t i = 0; i < count; ++i)
    norm += static_cast<double>(gradient[i]) * static_cast<double>(gradient[i]);
  const auto scale = static_cast<float>(std::min(1.0, kClip / (std::sqrt(norm) + 1e-6)));
  const auto age = static_cast<double>(steps_);
  const auto pace = static_cast<float>(rate / (1.0 - std::pow(0.9, age)));
  const auto correction = static_cast<float>(1.0 / std::sqrt(1.0 - std::pow(0.999, age)));
  const auto keep = static_cast<float>(1.0 - rate * weight_decay_);
  float* mean = mean_.data();
  float* square = square_.data();
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const float g = scale * gradient[i];
    mean[i] = beta1 * mean[i] + (1.0F - beta1) * g;
    square[i] = beta2 * square[i] + (1.0F - beta2) * g * g;
    parameter[i] = keep * parameter[i] - pace * mean[i] / (std::sqrt(square[i]) * correction + epsilon);
  }
}

}  // namespace s2nnds
