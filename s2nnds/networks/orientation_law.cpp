// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/orientation_law.h"

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/data/orientation.h"

namespace s2nnds {

void OrientationLaw::check(Eigen::Index dimension) const {
  psi.check();
  s2nnds::check(
      psi.input_dimension() == dimension && psi.output_dimension() == 3 && psi.head == Head::zero_at_origin,
      "orientation: found psi {} -> {} with head {}, expected {} -> 3 with head zero_at_origin",
      psi.input_dimension(), psi.output_dimension(), to_string(psi.head), dimension);
  s2nnds::check(rate > 0.0 && std::isfinite(rate), "orientation: found the rate {}, expected a number > 0",
                rate);
  s2nnds::check(initial_error > 0.0 && initial_error < M_PI,
                "orientation: found an initial error of {} rad, expected one in (0, pi)", initial_error);
}

std::string OrientationLaw::hash() const { return weight_hash({psi, {}, {}}); }

Points OrientationLaw::angular_velocity(const Eigen::Vector4d& goal, const Points& z, const Points& zdot,
                                        const Points& orientation) const {
  Points target, change;
  psi.value_and_derivative(z, zdot, target, change);
  const Points r = rotation_vectors(goal, orientation);
  const Points rdot = change - rate * (r - target);
  const Eigen::Matrix3d to_data = rotation_matrix(goal);
  Points omega(z.rows(), 3);
  for (Eigen::Index i = 0; i < z.rows(); ++i)
    omega.row(i) = (to_data * left_jacobian(r.row(i).transpose()) * rdot.row(i).transpose()).transpose();
  return omega;
}

Points OrientationLaw::follow(const Eigen::Vector4d& goal, const Vector& time, const Points& z,
                              const Eigen::Vector4d& start) const {
  Points r = psi.value(z);
  const Eigen::RowVector3d error = rotation_vector(product(inverse(goal), start)).transpose() - r.row(0);
  for (Eigen::Index i = 0; i < r.rows(); ++i) r.row(i) += std::exp(-rate * (time[i] - time[0])) * error;
  return orientations(goal, r);
}

}  // namespace s2nnds
