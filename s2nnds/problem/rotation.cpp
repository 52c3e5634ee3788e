// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/rotation.h"

#include <Eigen/Dense>
#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

Rotation from_enclosure(std::vector<Interval> enclosure, const std::string& text) {
  const auto n = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(enclosure.size()))));
  Points matrix(n, n);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    const Interval& entry = enclosure[static_cast<std::size_t>(i)];
    matrix.data()[i] = 0.5 * entry.lower + 0.5 * entry.upper;
  }
  return {std::move(matrix), std::move(enclosure), text};
}

// Numbers (x, y, z, w): the rotation that q v q^-1 is, exact for any length of q.
Rotation from_quaternion(const Eigen::Vector4d& q) {
  const Interval x = q[0], y = q[1], z = q[2], w = q[3];
  const Interval scale = Interval(2.0) / (square(x) + square(y) + square(z) + square(w));
  const Interval one = 1.0;
  return from_enclosure(
      {one - scale * (square(y) + square(z)), scale * (x * y - z * w), scale * (x * z + y * w),
       scale * (x * y + z * w), one - scale * (square(x) + square(z)), scale * (y * z - x * w),
       scale * (x * z - y * w), scale * (y * z + x * w), one - scale * (square(x) + square(y))},
      fmt::format("rotation ({}, {}, {}, {})", q[0], q[1], q[2], q[3]));
}

}  // namespace

Rotation no_rotation(Eigen::Index dimension) {
  std::vector<Interval> enclosure;
  for (Eigen::Index k = 0; k < dimension * dimension; ++k) {
    enclosure.push_back(k % (dimension + 1) == 0 ? 1.0 : 0.0);
  }
  return from_enclosure(std::move(enclosure), "");
}

Rotation rotation_by_angle(double radians) {
  check(std::isfinite(radians), "angle: found {}, expected a finite number of radians", radians);
  const Interval c = cos(Interval(radians)), s = sin(Interval(radians));
  return from_enclosure({c, -s, s, c}, fmt::format("angle {}", radians));
}

Rotation rotation_in_space(const std::vector<double>& numbers) {
  check(numbers.size() == 4 || numbers.size() == 9,
        "rotation: found {} numbers, expected 4 of a quaternion (x, y, z, w) or 9 of a matrix",
        numbers.size());
  if (numbers.size() == 4) {
    const Eigen::Vector4d q(numbers.data());
    check(q.allFinite() && q.norm() > 1e-6 && q.norm() < 1e6,
          "rotation: found a quaternion of length {}, expected a length near 1", q.norm());
    return from_quaternion(q);
  }
  const Eigen::Matrix3d matrix =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data());
  const double error = (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  check(
      error <= 1e-6 && matrix.determinant() > 0.0,
      "rotation: the matrix times its transpose is off the identity by {:.2g} and its determinant is {:.6g}; "
      "expected a rotation",
      error, matrix.determinant());
  return from_quaternion(Eigen::Quaterniond(matrix).normalized().coeffs());
}

}  // namespace s2nnds
