// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/conditions/worst_perturbation.h"

namespace s2nnds {

template <typename T>
Vector perturbation_work(const ExecutionModel& model, const BasicEvaluator<T>& function,
                         const BasicEvaluator<T>& f, const Points& x, const Points& velocity) {
  const Eigen::Index n = x.cols();
  Points gradient(x.rows(), n), jacobian(x.rows(), n * n), value, derivative,
      direction = Points::Zero(x.rows(), n);
  for (Eigen::Index axis = 0; axis < n; ++axis) {
    direction.setZero();
    direction.col(axis).setOnes();
    function.value_and_derivative(x, direction, value, derivative);
    gradient.col(axis) = derivative.col(0);
    if (!model.displaces()) continue;
    f.value_and_derivative(x, direction, value, derivative);
    for (Eigen::Index i = 0; i < n; ++i) jacobian.col(i * n + axis) = derivative.col(i);
  }
  Vector work(x.rows()), delta(n);
  for (Eigen::Index row = 0; row < x.rows(); ++row) {
    worst_perturbation(model, n, gradient.row(row).data(), velocity.row(row).data(), jacobian.row(row).data(),
                       delta.data());
    work[row] = gradient.row(row).dot(delta);
  }
  return work;
}

template Vector perturbation_work(const ExecutionModel&, const BasicEvaluator<float>&,
                                  const BasicEvaluator<float>&, const Points&, const Points&);
template Vector perturbation_work(const ExecutionModel&, const BasicEvaluator<double>&,
                                  const BasicEvaluator<double>&, const Points&, const Points&);

}  // namespace s2nnds
