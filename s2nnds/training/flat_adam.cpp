// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/flat_adam.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace s2nnds {
namespace {

constexpr double kClip = 1.0;  // norm of the gradient: no single batch moves the weights far

// In several sums side by side: one would wait for its own last addition.
double squared_norm(const float* x, std::ptrdiff_t count) {
  constexpr std::ptrdiff_t kSums = 8;
  double sums[kSums] = {};
  const std::ptrdiff_t whole = count - count % kSums;
  for (std::ptrdiff_t i = 0; i < whole; i += kSums)
    for (std::ptrdiff_t k = 0; k < kSums; ++k)
      sums[k] += static_cast<double>(x[i + k]) * static_cast<double>(x[i + k]);
  for (std::ptrdiff_t i = whole; i < count; ++i)
    sums[i - whole] += static_cast<double>(x[i]) * static_cast<double>(x[i]);
  return std::accumulate(sums, sums + kSums, 0.0);
}

}  // namespace

void FlatAdam::step(double rate, std::ptrdiff_t count, const float* gradient, float* parameter) {
  constexpr float beta1 = 0.9F, beta2 = 0.999F, epsilon = 1e-8F;
  mean_.resize(static_cast<std::size_t>(count));
  square_.resize(static_cast<std::size_t>(count));
  ++steps_;
  const auto scale =
      static_cast<float>(std::min(1.0, kClip / (std::sqrt(squared_norm(gradient, count)) + 1e-6)));
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
