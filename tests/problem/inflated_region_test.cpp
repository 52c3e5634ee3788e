// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/inflated_region.h"

#include <gtest/gtest.h>

#include "region_attack.h"
#include "s2nnds/core/check.h"
#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

TEST(Inflated, ExactWhereTheLevelIsTheDistance) {
  const Points square{{0.0, 0.0}, {0.5, 0.0}, {0.5, 0.3}, {0.0, 0.3}};
  const Reference rounded = [&](const Vector& x) { return polygon_distance(square, x) - 0.2; };
  const Box around{Vector{{-0.5, -0.5}}, Vector{{1.0, 0.8}}};
  attack(region_of("type = \"polygon\"\nvertices = [[0,0],[0.5,0],[0.5,0.3],[0,0.3]]\ninflate = 0.2", 2),
         around, rounded, 2000);
  attack(region_of("type = \"box\"\nlower = [0, 0]\nupper = [0.5, 0.3]\ninflate = 0.2", 2), around, rounded,
         2000);
  attack(region_of(
             "type = \"union\"\ninflate = 0.05\nof = [{type = \"box\", lower = [0, 0], upper = [0.5, 0.3], "
             "inflate = 0.15}]",
             2),
         around, rounded, 2000);
  attack(
      region_of("type = \"ball\"\ncenter = [0, 0]\nradius = 0.3\ninflate = 0.2", 2), Box::cube(2, 1.0),
      [](const Vector& x) { return x.norm() - 0.5; }, 1000);
  EXPECT_EQ(region_of("type = \"ball\"\ncenter = [0, 0]\nradius = 0.3\ninflate = 0.2", 2)->describe(),
            "[ball centre (0, 0) radius 0.3] inflated by 0.2");
}

TEST(Inflated, InfiniteSidesStayInfinite) {
  const RegionPtr wall =
      region_of("type = \"box\"\nlower = [0, -inf]\nupper = [inf, inf]\ninflate = 0.25", 2);
  EXPECT_NEAR(wall->level(Points{{-0.5, 3.0}})[0], 0.25, 1e-15);
  EXPECT_EQ(wall->classify({Vector{{-0.2, -5.0}}, Vector{{3.0, 5.0}}}), Location::inside);
  EXPECT_EQ(wall->classify({Vector{{-1.0, -5.0}}, Vector{{-0.26, 5.0}}}), Location::outside);
}

// Every point within the radius of a point of the region is held, and none is called outside.
TEST(Inflated, HoldsAllWithinTheRadiusForEveryType) {
  const double radius = 0.15;
  for (const std::string& keys :
       {std::string("type = \"ellipsoid\"\ncenter = [0.1, 0]\nsemi_axes = [0.5, 0.2]"),
        std::string("type = \"halfspace\"\nnormal = [3, 4]\noffset = -1"),
        std::string("type = \"polytope\"\nnormals = [[1, 0], [-1, 3], [-1, -3]]\noffsets = [0.4, 0.5, 0.5]"),
        std::string("type = \"intersection\"\nof = [{type = \"ball\", center = [0.3, 0], radius = 0.4}, "
                    "{type = \"ball\", center = [-0.3, 0], radius = 0.4}]"),
        std::string("type = \"complement\"\nof = [{type = \"ball\", center = [0, 0], radius = 0.6}]"),
        std::string("type = \"polynomial\"\nlevel = \"x^2 + 4*y^2 - 0.09\""),
        std::string("type = \"expression\"\nlevel = \"max(abs(x) - 0.3, abs(y) - 0.1)\"")}) {
    const RegionPtr base = region_of(keys, 2), grown = region_of(keys + "\ninflate = 0.15", 2);
    RandomStream random(9, "inflate");
    const Points from = RegionSampler(base, Box::cube(2, 0.8)).sample(400, random);
    for (Eigen::Index k = 0; k < from.rows(); ++k) {
      const double angle = random.uniform(0.0, 2 * M_PI);
      const Vector x =
          from.row(k).transpose() + (radius - 1e-12) * Vector{{std::cos(angle), std::sin(angle)}};
      ASSERT_TRUE(grown->contains(x)) << keys << " " << x.transpose();
      const double size = std::pow(10.0, random.uniform(-4.0, -0.5));
      ASSERT_NE(grown->classify({x.array() - size, x.array() + 0.3 * size}), Location::outside) << keys;
    }
  }
}

TEST(Inflated, PolynomialsGrowByLittleMoreThanTheRadius) {
  const RegionPtr disc = region_of("type = \"polynomial\"\nlevel = \"x^2 + y^2 - 0.04\"\ninflate = 0.2", 2);
  EXPECT_TRUE(disc->contains(Vector{{0.28, 0.28}}));
  EXPECT_FALSE(disc->contains(Vector{{0.32, 0.32}}));
  EXPECT_EQ(disc->classify({Vector{{0.5, 0.0}}, Vector{{0.6, 0.1}}}), Location::outside);
  EXPECT_EQ(disc->classify({Vector{{-0.1, -0.1}}, Vector{{0.1, 0.1}}}), Location::inside);
  // Not defined nearby: nothing is said.
  const RegionPtr root = region_of("type = \"expression\"\nlevel = \"sqrt(x) - 1\"\ninflate = 0.1", 2);
  EXPECT_EQ(root->classify({Vector{{0.05, 0.0}}, Vector{{0.06, 0.1}}}), Location::unknown);
  EXPECT_THROW(root->level(Points{{0.05, 0.0}}), Error);
}

TEST(Inflated, BadRadiiAreNamed) {
  const std::string ball = "type = \"ball\"\ncenter = [0, 0]\nradius = 0.3\ninflate = ";
  expect_message(message_of([&] { region_of(ball + "-0.1", 2); }), "inflate");
  expect_message(message_of([&] { region_of(ball + "nan", 2); }), "inflate");
  expect_message(message_of([&] { region_of(ball + "inf", 2); }), "inflate");
  expect_message(message_of([&] { region_of("type = \"none\"\ninflate = 1", 2); }), "unknown key inflate");
}

}  // namespace
}  // namespace s2nnds
