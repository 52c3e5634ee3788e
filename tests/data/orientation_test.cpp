// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/orientation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

Eigen::Vector3d draw(RandomStream& random, double size) {
  const Eigen::Vector3d r(random.normal(), random.normal(), random.normal());
  return size * r.normalized();
}

TEST(Orientation, RotationVectorsAndQuaternionsAreInverse) {
  RandomStream random(1, "orientation-test");
  for (const double size : {0.0, 1e-12, 1e-7, 1e-3, 0.5, 2.0, 3.1, 3.1415}) {
    const Eigen::Vector3d r = draw(random, size);
    const Eigen::Vector4d q = quaternion_of(r);
    EXPECT_NEAR(q.norm(), 1.0, 1e-15);
    EXPECT_LE((rotation_vector(q) - r).norm(), 1e-12 * std::max(size, 1e-3)) << size;
    EXPECT_LE((rotation_vector(-q) - r).norm(), 1e-12 * std::max(size, 1e-3)) << size;
    EXPECT_NEAR(angle_between({1, 0, 0, 0}, q), size, 1e-12);
    const Eigen::Matrix3d expected = size == 0.0 ? Eigen::Matrix3d::Identity()
                                                 : Eigen::AngleAxisd(size, r.normalized()).toRotationMatrix();
    EXPECT_LE((rotation_matrix(q) - expected).norm(), 1e-12);
  }
}

TEST(Orientation, TheLeftJacobianTellsTheAngularVelocity) {
  RandomStream random(2, "orientation-test");
  for (const double size : {0.0, 1e-6, 1e-4, 0.3, 2.0, 3.0}) {
    const Eigen::Vector3d r = draw(random, size), rate = draw(random, 1.0);
    const double h = 1e-5;
    const Eigen::Vector4d before = quaternion_of(r - h * rate), after = quaternion_of(r + h * rate);
    const Eigen::Vector3d omega = rotation_vector(product(after, inverse(before))) / (2 * h);
    EXPECT_LE((left_jacobian(r) * rate - omega).norm(), 1e-8) << size;
  }
}

TEST(Orientation, TheMeanDoesNotDependOnSigns) {
  RandomStream random(3, "orientation-test");
  const Eigen::Vector4d middle = quaternion_of(draw(random, 2.5));
  Points all(6, 4);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Vector3d r = draw(random, 0.2);
    all.row(2 * i) = product(middle, quaternion_of(r)).transpose();
    all.row(2 * i + 1) = -product(middle, quaternion_of(-r)).transpose();
  }
  EXPECT_LE(angle_between(mean_orientation(all), middle), 1e-7);
}

}  // namespace
}  // namespace s2nnds
