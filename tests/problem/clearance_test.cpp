// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/clearance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/random.h"
#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

Vector point(std::initializer_list<double> x) {
  return Eigen::Map<const Vector>(x.begin(), static_cast<Eigen::Index>(x.size()));
}

TEST(Clearance, IsTheDistanceFromABall) {
  for (const Eigen::Index n : {2, 3, 6}) {
    const RegionPtr obstacle = ball(Vector::Constant(n, 0.3), 0.2);
    RandomStream random(0, "clearance");
    const Points points = uniform_points(Box::cube(n, 1), 50, random);
    const Vector distances =
        (points.rowwise() - Vector::Constant(n, 0.3).transpose()).rowwise().norm().array() - 0.2;
    const Clearance found = clearance(*obstacle, points, Box::cube(n, 2), 1e-4);
    Eigen::Index nearest = 0;
    const double least = distances.minCoeff(&nearest);
    if (least <= 0) {
      EXPECT_EQ(found.distance, 0);
      EXPECT_EQ(found.inside, (distances.array() <= 0).count());
      continue;
    }
    EXPECT_LE(found.distance, least + 1e-12);
    EXPECT_GE(found.distance, least - 2e-4);
    EXPECT_TRUE(found.at.isApprox(points.row(nearest).transpose()));
    EXPECT_NEAR((found.in_region - found.at).norm(), found.distance, 1e-4);
  }
}

// Their levels are no distances: the box's is the largest excess, the expression's anything.
TEST(Clearance, NeedsNoLevelThatIsADistance) {
  Points points(2, 2);
  points << 0, 0, 0.1, -0.1;
  const RegionPtr box = box_region({point({0.4, 0.3}), point({2, 2})});
  EXPECT_NEAR(clearance(*box, points, Box::cube(2, 3), 1e-4).distance, 0.5, 2e-4);
  EXPECT_NEAR(clearance(*expression("1000 * (1 - x)", 2), points, Box::cube(2, 3), 1e-4).distance, 0.9, 2e-4);
  const RegionPtr both = unite({box, ball(point({-0.6, 0}), 0.2)});
  EXPECT_NEAR(clearance(*both, points, Box::cube(2, 3), 1e-4).distance, 0.4, 2e-4);
}

TEST(Clearance, TellsPointsInsideAndNoRegion) {
  Points points(3, 2);
  points << 0, 0, 0.5, 0.5, 0.6, 0.5;
  const Clearance inside = clearance(*ball(point({0.5, 0.5}), 0.2), points, Box::cube(2, 1), 1e-3);
  EXPECT_EQ(inside.inside, 2);
  EXPECT_EQ(inside.distance, 0);
  EXPECT_TRUE(inside.at.isApprox(point({0.5, 0.5})));
  EXPECT_TRUE(std::isinf(clearance(*empty_region(2), points, Box::cube(2, 1), 1e-3).distance));
  EXPECT_TRUE(std::isinf(clearance(*ball(point({5, 5}), 0.2), points, Box::cube(2, 1), 1e-3).distance));
}

}  // namespace
}  // namespace s2nnds
