// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>

#include "s2nnds/conditions/execution_model.h"
#include "s2nnds/networks/evaluator.h"

namespace s2nnds {

// Of the perturbations delta in xdot = speed (f(x) + delta) that the model admits at a place x, the one that
// raises a function y(x) the most: grad y . delta is what must be added to grad y . f. To first order in the
// distance of the readings, so an estimate; verification/executed_motion.h bounds it on boxes. With f(y) -
// f(x) = J (error of the reading - what was moved since) and p = J' grad y it is
//   |p| position_error + window (most_speed |p . f| + |p| |error of xdot|) + |grad y| |error of xdot| / least_speed.
// Reads grad y [n], f [n] and J [n, n] (row-major, null where the model does not displace readings); writes
// delta [n].
template <typename T>
void worst_perturbation(const ExecutionModel& model, std::ptrdiff_t n, const T* gradient, const T* velocity,
                        const T* jacobian, T* delta) {
  const auto norm = [n](const auto& component) {
    double sum = 0.0;
    for (std::ptrdiff_t i = 0; i < n; ++i) sum += component(i) * component(i);
    return std::sqrt(sum);
  };
  const auto share = [](double size, double of) { return of > 0.0 ? size / of : 0.0 * of; };  // NaN stays
  const auto pulled = [&](std::ptrdiff_t j) {
    double sum = 0.0;
    for (std::ptrdiff_t i = 0; i < n; ++i) sum += static_cast<double>(gradient[i]) * jacobian[i * n + j];
    return sum;
  };
  const double command = norm([&](std::ptrdiff_t i) { return static_cast<double>(velocity[i]); }) +
                         model.field_error,
               relative = model.velocity_error_relative * command + model.field_error,
               noise = share(model.velocity_error / model.least_speed + relative,
                             norm([&](std::ptrdiff_t i) { return static_cast<double>(gradient[i]); }));
  for (std::ptrdiff_t i = 0; i < n; ++i) delta[i] = static_cast<T>(noise * gradient[i]);
  if (!model.displaces()) return;
  const double window = model.window() + model.lag;
  double along = 0.0;
  for (std::ptrdiff_t j = 0; j < n; ++j) along += pulled(j) * velocity[j];
  const double error = model.position_error + window * (model.velocity_error + model.most_speed * relative),
               from_error = share(error, norm(pulled)),
               from_motion = std::copysign(window * model.most_speed, along);
  for (std::ptrdiff_t j = 0; j < n; ++j) {
    const double displacement = from_error * pulled(j) + from_motion * velocity[j];
    for (std::ptrdiff_t i = 0; i < n; ++i) delta[i] += static_cast<T>(jacobian[i * n + j] * displacement);
  }
}

// grad y . delta of worst_perturbation for y = V or B at points [N, n] -> [N]; `velocity` [N, n] is f there.
template <typename T>
Vector perturbation_work(const ExecutionModel& model, const BasicEvaluator<T>& function,
                         const BasicEvaluator<T>& f, const Points& x, const Points& velocity);

}  // namespace s2nnds
