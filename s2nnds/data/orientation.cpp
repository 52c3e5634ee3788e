// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/orientation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

namespace s2nnds {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r) {
  Eigen::Matrix3d m;
  m << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  return m;
}

}  // namespace

Eigen::Vector4d product(const Eigen::Vector4d& a, const Eigen::Vector4d& b) {
  const Eigen::Vector3d u = a.tail<3>(), v = b.tail<3>();
  Eigen::Vector4d c;
  c[0] = a[0] * b[0] - u.dot(v);
  c.tail<3>() = a[0] * v + b[0] * u + u.cross(v);
  return c;
}

Eigen::Vector4d inverse(const Eigen::Vector4d& q) { return {q[0], -q[1], -q[2], -q[3]}; }

Eigen::Vector4d quaternion_of(const Eigen::Vector3d& r) {
  const double angle = r.norm();
  // sin(angle / 2) / angle
  const double share = angle < 1e-6 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  return {std::cos(0.5 * angle), share * r.x(), share * r.y(), share * r.z()};
}

Eigen::Vector3d rotation_vector(const Eigen::Vector4d& q) {
  const double sign = q[0] < 0.0 ? -1.0 : 1.0, sine = q.tail<3>().norm(), cosine = std::abs(q[0]);
  // 2 atan(sine / cosine) / sine
  const double share = sine < 1e-8 ? 2.0 / cosine : 2.0 * std::atan2(sine, cosine) / sine;
  return sign * share * q.tail<3>();
}

Points rotation_vectors(const Eigen::Vector4d& goal, const Points& orientation) {
  Points r(orientation.rows(), 3);
  for (Eigen::Index i = 0; i < r.rows(); ++i) {
    const Eigen::Vector4d q = orientation.row(i).transpose();
    r.row(i) = rotation_vector(product(inverse(goal), q)).transpose();
  }
  return r;
}

Points orientations(const Eigen::Vector4d& goal, const Points& r) {
  Points orientation(r.rows(), 4);
  for (Eigen::Index i = 0; i < r.rows(); ++i) {
    const Eigen::Vector3d one = r.row(i).transpose();
    orientation.row(i) = product(goal, quaternion_of(one)).transpose();
  }
  return orientation;
}

double angle_between(const Eigen::Vector4d& a, const Eigen::Vector4d& b) {
  const Eigen::Vector4d c = product(inverse(a), b);
  return 2.0 * std::atan2(c.tail<3>().norm(), std::abs(c[0]));
}

Eigen::Matrix3d rotation_matrix(const Eigen::Vector4d& q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& r) {
  const double square = r.squaredNorm(), angle = std::sqrt(square);
  const bool small = angle < 1e-4;  // the series: what it leaves out is below 1e-18
  const double first = small ? 0.5 - square / 24.0 : (1.0 - std::cos(angle)) / square;
  const double second = small ? 1.0 / 6.0 - square / 120.0 : (angle - std::sin(angle)) / (square * angle);
  const Eigen::Matrix3d cross = cross_matrix(r);
  return Eigen::Matrix3d::Identity() + first * cross + second * cross * cross;
}

Eigen::Vector4d mean_orientation(const Points& orientation) {
  const Eigen::Matrix4d sum = orientation.transpose() * orientation;
  Eigen::Vector4d mean = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(sum).eigenvectors().col(3);
  if (mean.dot(orientation.row(0).transpose()) < 0.0) mean = -mean;
  return mean.normalized();
}

double degrees(double radians) { return radians * (180.0 / M_PI); }

}  // namespace s2nnds
