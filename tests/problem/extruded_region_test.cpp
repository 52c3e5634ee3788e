// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/extruded_region.h"

#include <gtest/gtest.h>

#include "s2nnds/problem/framed_region.h"
#include "tests/problem/region_attack.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double disc(const Vector& x) { return (x.head(2) - Eigen::Vector2d(0.3, -0.2)).norm() - 0.4; }
RegionPtr disc_region() { return ball(Vector{{0.3, -0.2}}, 0.4); }

TEST(ExtrudedRegion, ForgetsTheLastCoordinateSoundly) {
  attack(extruded(disc_region()), Box::cube(3, 1.0), disc, 4000);
  attack(
      extruded(disc_region(), -0.3, 0.8), Box::cube(3, 1.0),
      [](const Vector& x) {
        return std::max({disc(x), -0.3 - x[2], x[2] - 0.8});
      },
      4000);
  attack(
      extruded(disc_region(), -kInfinity, 0.2), Box::cube(3, 1.0),
      [](const Vector& x) { return std::max(disc(x), x[2] - 0.2); }, 4000);
  // In the data's frame, as problems see it.
  const Vector goal{{0.5, -0.25, 0.0}};
  attack(
      framed(extruded(disc_region()), goal, 2.0), Box::cube(3, 0.5),
      [&](const Vector& z) { return disc(goal + 2.0 * z) / 2.0; }, 4000);
}

TEST(ExtrudedRegion, IsReadFromAConfiguration) {
  const char* const keys =
      "type = \"extrusion\"\nof = [{ type = \"ball\", center = [0.3, -0.2], radius = 0.4 }]\n";
  const RegionPtr endless = region_of(keys, 3);
  EXPECT_EQ(endless->dimension(), 3);
  EXPECT_TRUE(endless->is_lipschitz());
  EXPECT_EQ(endless->describe(), "ball centre (0.3, -0.2) radius 0.4, whatever the last coordinate");
  EXPECT_EQ(endless->classify({Vector{{0.2, -0.3, -1e9}}, Vector{{0.4, -0.1, 1e9}}}), Location::inside);
  EXPECT_EQ(endless->classify({Vector{{0.8, -0.3, -1e9}}, Vector{{0.9, -0.1, 1e9}}}), Location::outside);
  const RegionPtr bounded = region_of(std::string(keys) + "from = 0.95\nto = 1.05\n", 3);
  EXPECT_EQ(bounded->describe(), "ball centre (0.3, -0.2) radius 0.4, the last coordinate from 0.95 to 1.05");
  EXPECT_TRUE(bounded->contains(Vector{{0.3, 0.0, 1.0}}));
  EXPECT_FALSE(bounded->contains(Vector{{0.3, 0.0, 0.9}}));
  // As written, and back.
  RegionOptions options;
  read_toml(std::string(keys) + "to = 1.05\n", "test", options);
  RegionOptions again;
  read_toml(to_toml(options), "test", again);
  EXPECT_EQ(make_region(again, 3)->describe(), make_region(options, 3)->describe());
  // Grown in the plane by its own key, and all around by the extrusion's.
  EXPECT_TRUE(
      region_of(std::string(keys) + "to = 0.0\ninflate = 0.1\n", 3)->contains(Vector{{0.3, 0.0, 0.09}}));
}

TEST(ExtrudedRegion, MisuseIsRefused) {
  expect_message(message_of([] { extruded(disc_region(), 1.0, 0.0); }), "found from = 1 and to = 0");
  expect_message(message_of([] { extruded(disc_region(), NAN, 0.0); }), "expected from <= to");
  expect_message(message_of([] { region_of("type = \"extrusion\"\n", 3); }),
                 "of has 0 regions in 3 dimensions");
  expect_message(
      message_of([] {
        region_of("type = \"extrusion\"\nof = [{ type = \"ball\", center = [0, 0, 0], radius = 1 }]\n", 3);
      }),
      "center has 3 numbers, expected 2");
}

}  // namespace
}  // namespace s2nnds
