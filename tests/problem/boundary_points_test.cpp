// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/boundary_points.h"

#include <gtest/gtest.h>

namespace s2nnds {
namespace {

TEST(BoundaryPoints, OfABallAndTheirNormals) {
  for (const Eigen::Index n : {2, 3, 5}) {
    Vector centre = Vector::Zero(n);
    centre[0] = 0.4;
    RandomStream random(1, "boundary test");
    const BoundaryPoints b = boundary_points(ball(centre, 0.3), Box::cube(n, 1.25), 500, random);
    ASSERT_GT(b.point.rows(), 400);
    ASSERT_EQ(b.normal.rows(), b.point.rows());
    for (Eigen::Index i = 0; i < b.point.rows(); ++i) {
      const Vector out = b.point.row(i).transpose() - centre;
      EXPECT_NEAR(out.norm(), 0.3, 1e-9);
      EXPECT_LT((out / 0.3 - b.normal.row(i).transpose()).norm(), 1e-6);
    }
  }
}

// Half of the plane meets the workspace's faces: they are no boundary of the region.
TEST(BoundaryPoints, LieInsideTheBox) {
  RandomStream random(1, "boundary test");
  const RegionPtr right = halfspace((Vector(2) << -1.0, 0.0).finished(), -0.5);
  const BoundaryPoints b = boundary_points(right, Box::cube(2, 1.25), 500, random);
  ASSERT_GT(b.point.rows(), 100);
  EXPECT_LT((b.point.col(0).array() - 0.5).abs().maxCoeff(), 1e-9);
  EXPECT_LT(b.point.col(1).cwiseAbs().maxCoeff(), 1.25);
  EXPECT_LT((b.normal.col(0).array() + 1.0).abs().maxCoeff(), 1e-9);
}

TEST(BoundaryPoints, NoneWithoutARegion) {
  RandomStream random(1, "boundary test");
  EXPECT_EQ(boundary_points(empty_region(2), Box::cube(2, 1.0), 100, random).point.rows(), 0);
  // A set that covers the box has no boundary in it.
  EXPECT_EQ(boundary_points(ball(Vector::Zero(2), 9.0), Box::cube(2, 1.0), 100, random).point.rows(), 0);
}

}  // namespace
}  // namespace s2nnds
