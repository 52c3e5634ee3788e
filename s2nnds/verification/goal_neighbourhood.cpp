// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/goal_neighbourhood.h"

namespace s2nnds {
namespace {

constexpr double smallest_cube = 1e-7;

template <typename Holds>
double largest_cube(double largest, const Holds& holds) {
  for (double half = largest; half >= smallest_cube; half *= 0.5) {
    if (holds(half)) return half;
  }
  return 0.0;
}

}  // namespace

double positive_cube(const TaylorFunction& lyapunov, double largest) {
  return largest_cube(largest, [&](double half) {
    const auto gradient = lyapunov.goal_gradient_factor(half);
    return gradient && is_positive_definite(*gradient);
  });
}

double decreasing_cube(const TaylorFunction& field, const TaylorFunction& lyapunov, double largest) {
  return largest_cube(largest, [&](double half) {
    const auto velocity = field.goal_factor(half);
    const auto gradient = lyapunov.goal_gradient_factor(half);
    return velocity && gradient && is_positive_definite(-1.0 * (gradient->transposed() * *velocity));
  });
}

}  // namespace s2nnds
