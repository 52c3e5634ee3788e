// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/region.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/problem/framed_region.h"
#include "s2nnds/problem/inflated_region.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Named {
  std::string name;
  RegionPtr region;
  double volume;  // within [-1.25, 1.25]^2; negative: not known
};

std::vector<Named> all_regions() {
  const RegionPtr disc = ball(Vector{{-0.4, 0.35}}, 0.1);
  const RegionPtr wall = box_region({Vector{{0.3, 0.55}}, Vector{{kInfinity, 0.65}}});
  const RegionPtr oval = ellipsoid(Vector{{0.2, -0.3}}, Vector{{0.5, 0.2}});
  const RegionPtr half = halfspace(Vector{{1.0, -2.0}}, 0.3);
  return {{"none", empty_region(2), 0.0},
          {"ball", disc, M_PI * 0.01},
          {"box", wall, 0.95 * 0.1},
          {"ellipsoid", oval, M_PI * 0.1},
          {"halfspace", half, -1},
          {"polynomial", polynomial(Polynomial::from_text("x^2 + 4*y^2 + x*y - 0.3", 2), "p"), -1},
          {"triangle", expression("max(y, -4*x - 0.8*y - 1.6, 4*x - 0.8*y + 0.8)", 2), -1},
          // Area of |x/a|^(2/3) + |y/b|^(2/3) <= 1 is 3 pi a b / 8; a = 6 * 0.15^1.5, b = 3 * 0.15^1.5.
          {"astroid", expression("(((x+0.3)/6)**2)**(1/3) + (((y-0.4)/3)**2)**(1/3) - 0.15", 2),
           3 * M_PI / 8 * 18 * 0.15 * 0.15 * 0.15},
          {"wave",
           expression("max(y + 0.2*sin(9.5*x - pi/6) - 0.5, 0.28 - 0.2*sin(9.5*x - pi/6) - y, x, -1 - x)", 2),
           -1},
          {"union", unite({disc, wall, oval}), M_PI * 0.01 + 0.095 + M_PI * 0.1},
          {"intersection", intersect({oval, half}), -1},
          {"complement", complement(oval), 6.25 - M_PI * 0.1},
          {"nested", complement(unite({complement(oval), disc})), M_PI * 0.1}};
}

Box random_box(RandomStream& random) {
  Box box{Vector(2), Vector(2)};
  for (int i = 0; i < 2; ++i) {
    box.lower[i] = random.uniform(-1.25, 1.25);
    box.upper[i] = box.lower[i] + std::pow(10.0, random.uniform(-4, 0));
  }
  return box;
}

Points random_points(RandomStream& random, const Box& box, Eigen::Index count) {
  Points x(count, box.dimension());
  for (Eigen::Index k = 0; k < count; ++k) {
    for (Eigen::Index i = 0; i < box.dimension(); ++i) x(k, i) = random.uniform(box.lower[i], box.upper[i]);
  }
  return x;
}

struct Volumes {
  double inside = 0.0, unknown = 0.0;
};

Volumes pave(const Region& region, const Box& box, int bisections) {
  const Location location = region.classify(box);
  if (location == Location::inside) return {.inside = box.volume()};
  if (location == Location::outside) return {};
  if (bisections == 0) return {.unknown = box.volume()};
  const auto [lower, upper] = box.bisect(box.widest_side());
  const Volumes a = pave(region, lower, bisections - 1), b = pave(region, upper, bisections - 1);
  return {a.inside + b.inside, a.unknown + b.unknown};
}

TEST(Region, ClassificationIsSoundAtRandomPoints) {
  RandomStream random(1, "region");
  for (const Named& r : all_regions()) {
    int decided = 0;
    for (int k = 0; k < 1500; ++k) {
      const Box box = random_box(random);
      const Location location = r.region->classify(box);
      decided += location != Location::unknown;
      const Vector level = r.region->level(random_points(random, box, 20));
      // 1e-12: the levels are rounded, the classification is not.
      if (location == Location::inside) {
        ASSERT_LE(level.maxCoeff(), 1e-12) << r.name;
      }
      if (location == Location::outside) {
        ASSERT_GE(level.minCoeff(), -1e-12) << r.name;
      }
      const Interval bound = r.region->enclosure(box);
      ASSERT_LE(level.maxCoeff(), bound.upper + 1e-12) << r.name;
      ASSERT_GE(level.minCoeff(), std::min(bound.lower, 1e300) - 1e-12) << r.name;
    }
    EXPECT_GT(decided, 600) << r.name << ": a classification that knows nothing is sound but useless";
  }
}

TEST(Region, UnknownVolumeShrinksLinearlyAndTheRestIsTheVolume) {
  const Box workspace = Box::cube(2, 1.25);
  for (const Named& r : all_regions()) {
    const Volumes coarse = pave(*r.region, workspace, 10), fine = pave(*r.region, workspace, 14);
    EXPECT_LE(fine.unknown, 0.4 * coarse.unknown) << r.name;  // a quarter in the limit
    EXPECT_LT(fine.unknown, 0.25) << r.name;
    if (r.volume >= 0.0) {
      EXPECT_LE(fine.inside, r.volume + 1e-9) << r.name;
      EXPECT_GE(fine.inside + fine.unknown, r.volume - 1e-9) << r.name;
    }
  }
}

// Also of sets grown, of which the level need not be the distance, and in another frame.
TEST(Region, BoundingHalfspacesHoldTheSetAndTouchIt) {
  RandomStream random(5, "halfspaces");
  std::vector<Named> regions = all_regions();
  for (const Named& named : all_regions()) {
    if (named.region->is_lipschitz())
      regions.push_back({"grown " + named.name, inflated(named.region, 0.17), 0.0});
  }
  for (const Named& named : std::vector<Named>(regions))
    regions.push_back({"framed " + named.name, framed(named.region, Vector{{0.2, -0.15}}, 1.7), 0.0});
  int bounds = 0;
  for (const auto& [name, region, volume] : regions) {
    double farthest = -kInfinity;
    for (int k = 0; k < 1000; ++k) {
      const Box box = random_box(random);
      const double level = k % 2 == 0 ? 0.0 : random.uniform(0.0, 0.1);
      const auto bound = region->bounding_halfspace(box, level);
      if (!bound) continue;
      ++bounds;
      const Points x = random_points(random, box, 50);
      const Vector levels = region->level(x);
      for (Eigen::Index i = 0; i < x.rows(); ++i) {
        if (levels[i] > level) continue;
        const double excess = x.row(i).dot(bound->normal) - bound->offset;
        ASSERT_LE(excess, 1e-14) << name << " level " << level;
        farthest = std::max(farthest, excess / bound->normal.norm());
      }
    }
    const bool is_round =
        name.ends_with("ball") || name.ends_with("ellipsoid") || name.ends_with("halfspace");
    if (is_round) {
      EXPECT_GT(farthest, -0.01) << name;
    }
  }
  EXPECT_GT(bounds, 10000);
  EXPECT_FALSE(complement(ball(Vector{{0.0, 0.0}}, 1.0))->bounding_halfspace(random_box(random), 0.0));
}

// The nearest half-space of a ball that was grown is that of the larger ball, exactly.
TEST(Region, KnownBoundingHalfspaces) {
  const Box box = {Vector{{0.8, -0.1}}, Vector{{1.0, 0.1}}};
  const RegionPtr region = framed(inflated(ball(Vector{{1.0, 0.0}}, 0.25), 0.5), Vector{{0.5, 0.0}}, 2.0);
  const auto bound = region->bounding_halfspace(box, 0.125);  // |2 z + (0.5, 0) - (1, 0)| <= 0.75 + 2 * 0.125
  ASSERT_TRUE(bound);
  EXPECT_NEAR(bound->normal[0], 2.0, 1e-14);
  EXPECT_NEAR(bound->normal[1], 0.0, 1e-14);
  EXPECT_NEAR(bound->offset, 1.5, 1e-14);
  const auto oval =
      inflated(ellipsoid(Vector{{0.0, 0.0}}, Vector{{0.5, 0.1}}), 0.1)->bounding_halfspace(box, 0.0);
  ASSERT_TRUE(oval);  // its level is 0.1 where both semi-axes are doubled
  EXPECT_NEAR(oval->offset / oval->normal[0], 1.0, 1e-14);
}

TEST(Region, KnownLevels) {
  const Points x{{1.0, 0.0}, {0.0, 0.5}};
  EXPECT_NEAR(ball(Vector{{0.0, 0.0}}, 0.25)->level(x)[0], 0.75, 1e-15);
  EXPECT_NEAR(box_region({Vector{{0.0, 0.25}}, Vector{{0.5, kInfinity}}})->level(x)[0], 0.5, 1e-15);
  EXPECT_NEAR(box_region({Vector{{-1.0, 0.25}}, Vector{{0.5, kInfinity}}})->level(x)[1], -0.25, 1e-15);
  EXPECT_NEAR(ellipsoid(Vector{{0.0, 0.0}}, Vector{{2.0, 0.25}})->level(x)[1], 0.25, 1e-15);
  EXPECT_NEAR(halfspace(Vector{{3.0, 4.0}}, 1.0)->level(x)[0], 0.4, 1e-15);
  EXPECT_EQ(empty_region(2)->level(x)[0], kInfinity);
  EXPECT_EQ(complement(empty_region(2))->classify(Box::cube(2, 1.0)), Location::inside);
}

TEST(Region, BoundariesBelongToTheSetAndToItsComplement) {
  const RegionPtr unit = box_region({Vector{{0.0, 0.0}}, Vector{{1.0, 1.0}}});
  const RegionPtr rest = complement(unit);
  const Box inner{Vector{{0.0, 0.0}}, Vector{{1.0, 1.0}}}, beside{Vector{{1.0, 0.0}}, Vector{{2.0, 1.0}}};
  const Box apart{Vector{{next_up(1.0), 0.0}}, Vector{{2.0, 1.0}}};
  const Box core{Vector{{0.0 + 1e-300, 1e-300}}, Vector{{next_down(1.0), next_down(1.0)}}};
  EXPECT_EQ(unit->classify(inner), Location::inside);
  EXPECT_EQ(unit->classify(beside), Location::unknown);  // they share a face
  EXPECT_EQ(unit->classify(apart), Location::outside);
  EXPECT_EQ(rest->classify(beside), Location::inside);
  EXPECT_EQ(rest->classify(inner), Location::unknown);  // its faces belong to the complement
  EXPECT_EQ(rest->classify(core), Location::outside);
  const Box point{Vector{{1.0, 0.5}}, Vector{{1.0, 0.5}}};
  EXPECT_EQ(unit->classify(point), Location::inside);
  EXPECT_EQ(rest->classify(point), Location::inside);
}

TEST(Region, DoubtfulBoxesAreUnknown) {
  const double nan = std::nan("");
  for (const Named& r : all_regions()) {
    for (const Box& box :
         {Box{Vector{{1.0, 0.0}}, Vector{{0.0, 1.0}}}, Box{Vector{{nan, 0.0}}, Vector{{1.0, 1.0}}},
          Box{Vector{{0.0, 0.0}}, Vector{{nan, 1.0}}},
          Box{Vector{{kInfinity, 0.0}}, Vector{{kInfinity, 1.0}}}}) {
      EXPECT_EQ(r.region->classify(box), Location::unknown) << r.name;
    }
    EXPECT_THROW(r.region->classify(Box::cube(3, 1.0)), Error) << r.name;
  }
  const Box everything = Box::cube(2, kInfinity);
  EXPECT_EQ(ball(Vector{{0.0, 0.0}}, 1.0)->classify(everything), Location::unknown);
  EXPECT_EQ(ball(Vector{{0.0, 0.0}}, 1.0)->classify({Vector{{2.0, 0.0}}, Vector{{kInfinity, kInfinity}}}),
            Location::outside);
  EXPECT_EQ(halfspace(Vector{{1.0, 0.0}}, 0.0)
                ->classify({Vector{{-kInfinity, -kInfinity}}, Vector{{0.0, kInfinity}}}),
            Location::inside);
  // Not defined for x < 0: neither inside nor outside, and no level there.
  const RegionPtr root = expression("sqrt(x) - 1", 2);
  EXPECT_EQ(root->classify({Vector{{-0.1, 0.0}}, Vector{{0.5, 1.0}}}), Location::unknown);
  EXPECT_EQ(root->classify({Vector{{0.1, 0.0}}, Vector{{0.5, 1.0}}}), Location::inside);
  EXPECT_THROW(root->level(Points{{-0.1, 0.0}}), Error);
  EXPECT_EQ(complement(root)->classify({Vector{{-0.1, 0.0}}, Vector{{0.5, 1.0}}}), Location::unknown);
  // Not defined at x = 0, though above 0 wherever it is defined.
  for (const char* level : {"x/x", "abs(x/x) + 1", "exp(1/x)", "max(1/x, 5)", "x^0.5/x", "x^-2", "x^(-0.5)",
                            "abs(log(x)) + 1", "abs(tan(pi/2 - x)) + 1"}) {
    EXPECT_EQ(expression(level, 2)->classify({Vector{{0.0, 0.0}}, Vector{{0.5, 1.0}}}), Location::unknown)
        << level;
    EXPECT_EQ(expression(level, 2)->classify({Vector{{0.4, 0.0}}, Vector{{0.5, 1.0}}}), Location::outside)
        << level;
  }
}

TEST(Region, PointsThatAreNoNumbersAreRefused) {
  for (const Named& r : all_regions()) {
    EXPECT_THROW(r.region->level(Points::Zero(3, 3)), Error) << r.name;
    if (r.name == "none") continue;
    EXPECT_THROW(r.region->level(Points{{0.0, 0.0}, {std::nan(""), std::nan("")}}), Error) << r.name;
  }
}

std::string message(const RegionOptions& options) {
  try {
    make_region(options, 2);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Region, OptionsMakeEveryType) {
  const RegionOptions disc{.type = "ball", .center = {0.5, 0.0}, .radius = 0.25};
  const RegionOptions everything{
      .type = "union",
      .of = {disc,
             {.type = "intersection",
              .of = {{.type = "box", .lower = {-1.0, -1.0}, .upper = {0.0, kInfinity}},
                     {.type = "halfspace", .normal = {0.0, 1.0}, .offset = -0.5}}},
             {.type = "polynomial", .level = "(x - 1)^2 + (y - 1)^2 - 0.01"},
             {.type = "polynomial", .level = "0.01 - (x + 1)^2 - (y - 1)^2", .sign = -1},
             {.type = "ellipsoid", .center = {0.0, 1.0}, .semi_axes = {0.1, 0.2}},
             {.type = "expression", .level = "abs(x - 2) + abs(y) - 0.1"},
             {.type = "complement", .of = {{.type = "ball", .center = {0.0, 0.0}, .radius = 9.0}}},
             {.type = "none"}}};
  const RegionPtr region = make_region(everything, 2);
  for (const Vector& in :
       {Vector{{0.6, 0.1}}, Vector{{-0.5, -0.7}}, Vector{{1.05, 1.0}}, Vector{{-1.05, 1.0}},
        Vector{{0.0, 1.15}}, Vector{{2.05, 0.04}}, Vector{{7.0, 7.0}}}) {
    EXPECT_TRUE(region->contains(in)) << in.transpose();
  }
  for (const Vector& out :
       {Vector{{0.0, 0.0}}, Vector{{-0.5, -0.4}}, Vector{{0.15, 1.0}}, Vector{{2.06, 0.06}}}) {
    EXPECT_FALSE(region->contains(out)) << out.transpose();
  }
  EXPECT_NE(region->describe().find("ball centre (0.5, 0) radius 0.25"), std::string::npos)
      << region->describe();
}

TEST(Region, WrongOptionsAreNamed) {
  EXPECT_NE(
      message({.type = "ball", .center = {1.0}, .radius = 1.0}).find("center has 1 numbers, expected 2"),
      std::string::npos);
  EXPECT_NE(message({.type = "ball", .center = {1.0, 0.0}}).find("radius"), std::string::npos);
  EXPECT_NE(message({.type = "ball", .center = {1.0, std::nan("")}, .radius = 1.0}).find("centre"),
            std::string::npos);
  EXPECT_NE(message({.type = "box", .lower = {1.0, 0.0}, .upper = {0.0, 1.0}}).find("lower <= upper"),
            std::string::npos);
  EXPECT_NE(message({.type = "ellipsoid", .center = {1.0, 0.0}, .semi_axes = {1.0, -1.0}}).find("semi_axes"),
            std::string::npos);
  EXPECT_NE(message({.type = "halfspace", .normal = {0.0, 0.0}}).find("normal"), std::string::npos);
  EXPECT_NE(message({.type = "polynomial"}).find("level and file"), std::string::npos);
  EXPECT_NE(message({.type = "polynomial", .file = "missing.json"}).find("missing.json"), std::string::npos);
  EXPECT_NE(message({.type = "complement"}).find("expected 1"), std::string::npos);
  EXPECT_NE(message({.type = "union"}).find("at least one"), std::string::npos);
  EXPECT_NE(message({.type = "auto"}).find("auto"), std::string::npos);
  EXPECT_NE(message({.type = "ballon"}).find("ballon"), std::string::npos);
  EXPECT_NE(message({.type = "union", .of = {{.type = "none"}, {.type = "expression", .level = "2x"}}})
                .find("of[1]"),
            std::string::npos);
}

TEST(Region, OptionsKnowOnlyTheKeysOfTheirType) {
  RegionOptions options;
  read_toml("type = \"ball\"\ncenter = [0.1, 0.2]\nradius = 0.3", "test", options);
  EXPECT_EQ(options.radius, 0.3);
  EXPECT_THROW(read_toml("type = \"ball\"\nlower = [0.1, 0.2]", "test", options), Error);
  EXPECT_THROW(read_toml("type = \"bal\"", "test", options), Error);
  RegionOptions nested;
  read_toml(
      "type = \"union\"\nof = [{type = \"box\", lower = [-inf, 0], upper = [1, inf]}, {type = \"none\"}]",
      "test", nested);
  ASSERT_EQ(nested.of.size(), 2u);
  RegionOptions again;
  read_toml(to_toml(nested), "again", again);
  EXPECT_EQ(make_region(again, 2)->describe(), make_region(nested, 2)->describe());
}

TEST(Box, HalvesAndCorners) {
  const Box box{Vector{{-1.0, 0.0}}, Vector{{2.0, 1.0}}};
  EXPECT_EQ(box.volume(), 3.0);
  EXPECT_EQ(box.widest_side(), 0);
  const auto [lower, upper] = box.bisect(0);
  EXPECT_EQ(lower.upper[0], 0.5);
  EXPECT_EQ(upper.lower[0], 0.5);
  EXPECT_TRUE(box.contains(Vector{{2.0, 1.0}}));
  EXPECT_FALSE(box.contains(Vector{{std::nan(""), 0.5}}));
  EXPECT_FALSE(box.contains(Vector{{0.0, 0.0, 0.0}}));
  EXPECT_TRUE(box.intersection({Vector{{3.0, 0.0}}, Vector{{4.0, 1.0}}}).is_empty());
  EXPECT_EQ(box.intersection({Vector{{3.0, 0.0}}, Vector{{4.0, 1.0}}}).volume(), 0.0);
  EXPECT_THROW(Box::cube(2, kInfinity).bisect(0), Error);
  // Rounded outwards: the half-widths reach both ends.
  const Box odd{Vector{{0.1}}, Vector{{0.7}}};
  EXPECT_GE(odd.half_widths()[0], odd.upper[0] - odd.center()[0]);
  EXPECT_GE(odd.half_widths()[0], odd.center()[0] - odd.lower[0]);
}

}  // namespace
}  // namespace s2nnds
