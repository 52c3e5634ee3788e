// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/design.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>

namespace s2nnds {
namespace {

const Axis unit{.key = "u", .low = 0.0, .high = 1.0};
const Axis other{.key = "v", .low = 0.0, .high = 1.0};
const Axis letters{.key = "w", .values = {"a", "b", "c"}};

SweepOptions options(const std::string& design, std::int64_t points, std::int64_t seed = 0) {
  SweepOptions made;
  made.design = design;
  made.points = points;
  made.design_seed = seed;
  return made;
}

TEST(Design, GridIsTheProductWithTheLastAxisFastest) {
  Axis steps{.key = "s", .low = 1, .high = 4, .integer = true, .count = 4};
  const auto points = make_design(options("grid", 0), {letters, steps});
  ASSERT_EQ(points.size(), 12U);
  EXPECT_EQ(points[0], (DesignPoint{"a", "1"}));
  EXPECT_EQ(points[1], (DesignPoint{"a", "2"}));
  EXPECT_EQ(points[4], (DesignPoint{"b", "1"}));
  EXPECT_EQ(std::set<DesignPoint>(points.begin(), points.end()).size(), 12U);
}

TEST(Design, WithoutAxesThereIsOnePoint) {
  EXPECT_EQ(make_design(options("grid", 0), {}).size(), 1U);
  EXPECT_EQ(make_design(options("sobol", 5), {}).size(), 1U);
}

// The first points of Sobol's sequence with the direction numbers of Joe and Kuo, without the origin.
TEST(Design, SobolsFirstPoints) {
  const std::vector<DesignPoint> expected = {{"0.5", "0.5"},     {"0.75", "0.25"},   {"0.25", "0.75"},
                                             {"0.375", "0.375"}, {"0.875", "0.875"}, {"0.625", "0.125"}};
  EXPECT_EQ(make_design(options("sobol", 6), {unit, other}), expected);
}

// Of 64 consecutive points, each of 8 x 8 boxes holds about one: at most 2 of a (0, 2)-sequence's, origin
// left out.
TEST(Design, SobolFillsTheSquareEvenly) {
  for (const std::int64_t seed : {0, 7}) {
    std::vector<int> counts(64, 0);
    for (const DesignPoint& point : make_design(options("sobol", 64, seed), {unit, other})) {
      const auto cell = [](const std::string& text) {
        return std::min(7, static_cast<int>(std::stod(text) * 8));
      };
      ++counts[cell(point[0]) * 8 + cell(point[1])];
    }
    EXPECT_LE(*std::max_element(counts.begin(), counts.end()), 2) << seed;
    EXPECT_GE(std::count_if(counts.begin(), counts.end(), [](int c) { return c > 0; }), 62) << seed;
  }
}

TEST(Design, TheSameSeedGivesTheSamePointsAnotherOneOthers) {
  for (const char* design : {"random", "sobol"}) {
    const auto first = make_design(options(design, 20, 3), {unit, letters});
    EXPECT_EQ(first, make_design(options(design, 20, 3), {unit, letters})) << design;
    EXPECT_NE(first, make_design(options(design, 20, 4), {unit, letters})) << design;
    const auto fewer = make_design(options(design, 5, 3), {unit, letters});
    EXPECT_TRUE(std::equal(fewer.begin(), fewer.end(), first.begin()))
        << design;  // more points keep the old ones
  }
}

// 3000 draws of three letters: each count is binomial with deviation 26, so 1000 +- 130 fails by chance in
// 1e-6.
TEST(Design, RandomDrawsAreUniform) {
  int a = 0;
  double sum = 0.0;
  for (const DesignPoint& point : make_design(options("random", 3000), {unit, letters})) {
    a += point[1] == "a" ? 1 : 0;
    sum += std::stod(point[0]);
  }
  EXPECT_NEAR(a, 1000, 130);
  EXPECT_NEAR(sum / 3000, 0.5, 0.027);
}

// Each time through, all pairs once; the order differs, so that no pair keeps to one part of Sobol's sequence.
TEST(Design, PairsTakeTurnsInAnotherOrderEachTime) {
  const auto pairs = pairs_in_turn(200, 60, 0);
  std::set<std::vector<std::int64_t>> orders;
  for (int pass = 0; pass < 3; ++pass) {
    const std::vector<std::int64_t> order(pairs.begin() + 60 * pass, pairs.begin() + 60 * (pass + 1));
    EXPECT_EQ(std::set<std::int64_t>(order.begin(), order.end()).size(), 60U);
    orders.insert(order);
  }
  EXPECT_EQ(orders.size(), 3U);
  const auto fewer = pairs_in_turn(70, 60, 0);
  EXPECT_TRUE(std::equal(fewer.begin(), fewer.end(), pairs.begin()));
  EXPECT_NE(pairs_in_turn(60, 60, 1), pairs_in_turn(60, 60, 0));
}

}  // namespace
}  // namespace s2nnds
