#include "s2nnds/training/flat_adam.h"

#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-8;

}  // namespace

FlatAdam::FlatAdam(torch::Tensor parameter, double weight_decay, double clip)
    : parameter_(std::move(parameter)), weight_decay_(weight_decay), clip_(clip) {
  check(parameter_.dim() == 1 && parameter_.is_contiguous() &&
            (parameter_.dtype() == torch::kFloat32 || parameter_.dtype() == torch::kFloat64),
        "optimiser: expected a contiguous parameter [count] of floating-point numbers");
  torch::NoGradGuard no_grad;
  mean_ = torch::zeros_like(parameter_);
  square_ = torch::zeros_like(parameter_);
}

void FlatAdam::zero_grad() { parameter_.mutable_grad() = torch::Tensor(); }

void FlatAdam::step(double rate) {
  check(parameter_.grad().defined(), "optimiser: the parameter has no gradient");
  ++steps_;
  if (parameter_.dtype() == torch::kFloat64) return update<double>(rate);
  update<float>(rate);
}

template <typename T>
void FlatAdam::update(double rate) {
  const torch::Tensor gradient = parameter_.grad().contiguous();
  const T* g = gradient.data_ptr<T>();
  T* theta = parameter_.data_ptr<T>();
  T* mean = mean_.data_ptr<T>();
  T* square = square_.data_ptr<T>();
  const std::int64_t count = parameter_.numel();
  double norm = 0.0;
  for (std::int64_t i = 0; i < count; ++i) norm += static_cast<double>(g[i]) * static_cast<double>(g[i]);
  norm = std::sqrt(norm);
  const T scale = static_cast<T>(std::min(1.0, clip_ / (norm + 1e-6)));
  const double age = static_cast<double>(steps_);
  const T pace = static_cast<T>(rate / (1.0 - std::pow(kBeta1, age)));
  const T correction = static_cast<T>(1.0 / std::sqrt(1.0 - std::pow(kBeta2, age)));
  const T keep = static_cast<T>(1.0 - rate * weight_decay_);
  constexpr T beta1 = kBeta1, beta2 = kBeta2, epsilon = kEpsilon;
  for (std::int64_t i = 0; i < count; ++i) {
    const T gradient_i = scale * g[i];
    mean[i] = beta1 * mean[i] + (T(1) - beta1) * gradient_i;
    square[i] = beta2 * square[i] + (T(1) - beta2) * gradient_i * gradient_i;
    theta[i] = keep * theta[i] - pace * mean[i] / (std::sqrt(square[i]) * correction + epsilon);
  }
}

}  // namespace s2nnds
