// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/orientation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

Eigen::Quaterniond quaternion(const Eigen::Vector4d& q) { return {q[0], q[1], q[2], q[3]}; }
Eigen::Vector4d numbers_of(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r) {
  Eigen::Matrix3d m;
  m << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  return m;
}

}  // namespace

std::array<Eigen::Index, 4> places_in(const std::string& order) {
  check(order == "xyzw" || order == "wxyz", "orientation: found the order '{}', expected xyzw or wxyz",
        order);
  if (order == "xyzw") return {3, 0, 1, 2};
  return {0, 1, 2, 3};
}

Eigen::Vector4d from_order(const Eigen::Vector4d& numbers, const std::string& order) {
  return numbers(places_in(order));
}

Eigen::Vector4d to_order(const Eigen::Vector4d& q, const std::string& order) {
  Eigen::Vector4d numbers;
  numbers(places_in(order)) = q;
  return numbers;
}

Eigen::Vector4d product(const Eigen::Vector4d& a, const Eigen::Vector4d& b) {
  return numbers_of(quaternion(a) * quaternion(b));
}

Eigen::Vector4d inverse(const Eigen::Vector4d& q) { return numbers_of(quaternion(q).conjugate()); }

Eigen::Vector4d quaternion_of(const Eigen::Vector3d& r) {
  return numbers_of(Eigen::Quaterniond(Eigen::AngleAxisd(r.norm(), r.stableNormalized())));
}

Eigen::Vector3d rotation_vector(const Eigen::Vector4d& q) {
  const Eigen::AngleAxisd turn(quaternion(q));
  return turn.angle() * turn.axis();
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
  return quaternion(a).angularDistance(quaternion(b));
}

Eigen::Matrix3d rotation_matrix(const Eigen::Vector4d& q) { return quaternion(q).toRotationMatrix(); }

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
