// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/framed_region.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_100;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One of every kind, as a configuration may write it for data in mm whose goal is far from the origin.
std::vector<RegionOptions> all_kinds() {
  const RegionOptions disc{.type = "ball", .center = {300.0, 400.0}, .radius = 40.0};
  const RegionOptions wall{.type = "box", .lower = {600.0, 100.0}, .upper = {kInfinity, 180.0}};
  return {disc,
          wall,
          {.type = "ellipsoid", .center = {400.0, 100.0}, .semi_axes = {150.0, 40.0}},
          {.type = "halfspace", .normal = {3.0, -4.0}, .offset = 250.0},
          {.type = "polynomial",
           .level = "0.001*(x - 450)^2 - 0.01*(x - 450)*(y - 300) + 0.0003*(y - 300)^4 - 30"},
          {.type = "expression", .level = "max(y - 350, 200*sin(x/80) - y, 300 - x)"},
          {.type = "union", .of = {disc, wall}},
          {.type = "intersection", .of = {{.type = "complement", .of = {disc}}, wall}},
          {.type = "complement", .of = {disc}}};
}

const Vector kGoal{{512.3, 201.7}};
constexpr double kScale = 397.1;

Box random_box(RandomStream& random, double size) {
  Box box{Vector(2), Vector(2)};
  for (Eigen::Index i = 0; i < 2; ++i) {
    const double a = random.uniform(-1.25, 1.25);
    box.lower[i] = a;
    box.upper[i] = a + size * random.uniform();
  }
  return box;
}

TEST(FramedRegion, IsTheRegionSeenFromTheGoal) {
  RandomStream random(3, "framed");
  for (const RegionOptions& options : all_kinds()) {
    const RegionPtr region = make_region(options, 2), inner = framed(region, kGoal, kScale);
    EXPECT_EQ(inner->dimension(), 2);
    EXPECT_EQ(inner->describe(), region->describe());
    Points z(1000, 2);
    for (double& coordinate : z.reshaped()) coordinate = random.uniform(-1.25, 1.25);
    const Points x = (kScale * z).rowwise() + kGoal.transpose();
    EXPECT_TRUE((kScale * inner->level(z)).isApprox(region->level(x), 1e-12)) << region->describe();
    EXPECT_TRUE(((inner->level(z).array() <= 0.0) == (region->level(x).array() <= 0.0)).all());
  }
}

// A decided box decides all of its points, corners included, whatever the rounding of the way back.
TEST(FramedRegion, ClassificationIsSoundForEveryKind) {
  RandomStream random(4, "framed boxes");
  for (const RegionOptions& options : all_kinds()) {
    const RegionPtr region = make_region(options, 2), inner = framed(region, kGoal, kScale);
    int decided = 0;
    for (int k = 0; k < 2000; ++k) {
      const Box box = random_box(random, k % 2 == 0 ? 0.2 : 1e-6);
      const Location location = inner->classify(box);
      decided += location != Location::unknown;
      for (int point = 0; point < 10; ++point) {
        Vector z(2);
        for (Eigen::Index i = 0; i < 2; ++i) {
          const double corner = random.uniform() < 0.5 ? box.lower[i] : box.upper[i];
          z[i] = point < 5
                     ? corner
                     : std::clamp(random.uniform(box.lower[i], box.upper[i]), box.lower[i], box.upper[i]);
        }
        // The region's own enclosure at the exact place, between its two neighbouring doubles.
        Box place{Vector(2), Vector(2)};
        for (Eigen::Index i = 0; i < 2; ++i) {
          const Exact exact = Exact(kGoal[i]) + Exact(kScale) * Exact(z[i]);
          const double near = exact.convert_to<double>();
          place.lower[i] = Exact(near) <= exact ? near : next_down(near);
          place.upper[i] = Exact(near) >= exact ? near : next_up(near);
        }
        const Location there = region->classify(place);
        if (location == Location::inside) {
          ASSERT_NE(there, Location::outside) << region->describe();
        }
        if (location == Location::outside) {
          ASSERT_NE(there, Location::inside) << region->describe();
        }
        const Interval level = inner->enclosure(box);
        if (level.is_defined()) {
          const Interval exact = region->enclosure(place);
          ASSERT_LE(level.lower * kScale, exact.upper + 1e-9) << region->describe();
          ASSERT_GE(level.upper * kScale, exact.lower - 1e-9) << region->describe();
        }
      }
    }
    EXPECT_GT(decided, 1200) << region->describe();
  }
}

TEST(FramedRegion, InfiniteBoxesAndDegenerateOnes) {
  const RegionPtr wall = framed(make_region(all_kinds()[1], 2), kGoal, kScale);
  EXPECT_EQ(wall->classify({Vector{{0.3, -0.2}}, Vector{{kInfinity, -0.1}}}), Location::inside);
  EXPECT_EQ(wall->classify({Vector{{-kInfinity, 0.0}}, Vector{{kInfinity, 1.0}}}), Location::outside);
  EXPECT_EQ(wall->classify({Vector{{-kInfinity, -1.0}}, Vector{{kInfinity, 1.0}}}), Location::unknown);
  EXPECT_EQ(wall->classify({Vector{{0.5, -0.2}}, Vector{{0.4, -0.1}}}), Location::unknown);  // empty
}

TEST(FramedRegion, MisuseIsRefused) {
  const RegionPtr disc = make_region(all_kinds()[0], 2);
  EXPECT_THROW(framed(disc, Vector::Zero(3), 1.0), Error);
  EXPECT_THROW(framed(disc, Vector{{0.0, kInfinity}}, 1.0), Error);
  EXPECT_THROW(framed(disc, Vector::Zero(2), 0.0), Error);
  EXPECT_THROW(framed(nullptr, Vector::Zero(2), 1.0), Error);
}

}  // namespace
}  // namespace s2nnds
