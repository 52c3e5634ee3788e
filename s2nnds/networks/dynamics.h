// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "s2nnds/networks/evaluator.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// `velocity` [n] becomes the one nearest to it along which a function of the given value and gradient [n] falls at
// least at the rate decay * value (Manek and Kolter, Learning stable deep dynamics models, 2019, equation 9):
//   velocity - gradient relu(gradient . velocity + decay value) / |gradient|^2.
// NaN goes through.
template <typename T>
void project_velocity(std::ptrdiff_t n, const T* gradient, double value, double decay, T* velocity) {
  double rate = 0.0, square = 0.0;
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    rate += static_cast<double>(gradient[k]) * static_cast<double>(velocity[k]);
    square += static_cast<double>(gradient[k]) * static_cast<double>(gradient[k]);
  }
  const double excess = rate + decay * value;
  if (excess <= 0.0) return;
  // At the goal both are 0, and so near to it that the square underflows nothing is to be gained.
  const double share = excess / std::fmax(square, std::numeric_limits<double>::min());
  for (std::ptrdiff_t k = 0; k < n; ++k)
    velocity[k] -= static_cast<T>(share * static_cast<double>(gradient[k]));
}

// What moves: x' = velocity(x). Where it is projected, V(x(t)) <= V(x(0)) e^(-decay t) along every motion.
struct Dynamics {
  NetworkWeights f;    // n -> n
  double decay = 0.0;  // kappa >= 0; 0: velocity = f
  NetworkWeights V;    // of the projection; without layers where there is none

  Dynamics(NetworkWeights field) : f(std::move(field)) {}  // NOLINT: a network alone moves as it says
  // The projection of `field`.
  Dynamics(NetworkWeights field, double rate, NetworkWeights lyapunov)
      : f(std::move(field)), decay(rate), V(std::move(lyapunov)) {}

  bool is_projected() const { return decay > 0.0; }  // whether the velocity may differ from f(x)
};

// Dynamics made ready for many evaluations. T as for BasicEvaluator.
template <typename T>
class BasicDynamicsEvaluator {
 public:
  explicit BasicDynamicsEvaluator(const Dynamics& dynamics);  // throws Error as BasicEvaluator does
  // Of networks, without a copy of what is not needed.
  explicit BasicDynamicsEvaluator(const Networks& networks);
  // velocity(x), [N, n] -> [N, n]; throws Error on a wrong shape.
  Points value(const Points& x) const;

 private:
  BasicEvaluator<T> f_;
  std::optional<BasicEvaluator<T>> V_;
  double decay_;
};

}  // namespace s2nnds
