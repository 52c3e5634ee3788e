// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/axis.h"

#include <gtest/gtest.h>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

using Texts = std::vector<std::string>;

std::string message_of(const std::string& axes) {
  try {
    read_axes("[axes]\n" + axes, "s.toml");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Axis, KeepsTheOrderOfTheFileAndEveryKindOfValue) {
  const auto axes = read_axes(
      "[axes]\n"
      "\"training.steps\" = [5, 7]\n"
      "networks.f.hidden = { values = [[32, 32], [64]], also = [\"networks.V.hidden\"] }\n"
      "\"problem.unsafe\" = [{ type = \"ball\", center = [0.5, 0.1], radius = 0.1 }]\n"
      "\"a\" = [\"x, y\", true, 1e-3]\n",
      "s.toml");
  ASSERT_EQ(axes.size(), 4U);
  EXPECT_EQ(axes[0].key, "training.steps");
  EXPECT_EQ(axes[0].line, 2);
  EXPECT_EQ(axes[0].values, (Texts{"5", "7"}));
  EXPECT_EQ(axes[1].key, "networks.f.hidden");
  EXPECT_EQ(axes[1].values, (Texts{"[32, 32]", "[64]"}));
  EXPECT_EQ(axes[1].also, Texts{"networks.V.hidden"});
  EXPECT_EQ(axes[2].values, Texts{"{center = [0.5, 0.1], radius = 0.1, type = \"ball\"}"});
  EXPECT_EQ(axes[3].values, (Texts{"\"x, y\"", "true", "0.001"}));
  EXPECT_TRUE(read_axes("name = \"none\"", "s.toml").empty());
}

TEST(Axis, GridsAreEvenAndHitTheirEnds) {
  EXPECT_EQ((Axis{.key = "a", .low = 0.0, .high = 1.0, .count = 5}).grid(),
            (Texts{"0.0", "0.25", "0.5", "0.75", "1.0"}));
  EXPECT_EQ((Axis{.key = "a", .low = 1e-4, .high = 1e-1, .logarithmic = true, .count = 4}).grid(),
            (Texts{"0.0001", "0.001", "0.01", "0.1"}));
  EXPECT_EQ((Axis{.key = "a", .low = 2, .high = 10, .integer = true, .count = 5}).grid(),
            (Texts{"2", "4", "6", "8", "10"}));
  EXPECT_EQ((Axis{.key = "a", .low = 1, .high = 3, .integer = true, .count = 9}).grid(),
            (Texts{"1", "2", "3"}));
  EXPECT_EQ(
      (Axis{.key = "a", .low = 1, .high = 100, .logarithmic = true, .integer = true, .count = 3}).grid(),
      (Texts{"1", "10", "100"}));
  EXPECT_EQ((Axis{.key = "a", .low = 1.0, .high = 4.0, .logarithmic = true, .count = 1}).grid(),
            Texts{"2.0"});
}

TEST(Axis, DrawsInEqualShares) {
  const Axis list{.key = "a", .values = {"x", "y", "z"}};
  EXPECT_EQ(list.at(0.0), "x");
  EXPECT_EQ(list.at(0.34), "y");
  EXPECT_EQ(list.at(0.999999), "z");
  const Axis dice{.key = "a", .low = 1, .high = 6, .integer = true};
  std::vector<int> counts(7, 0);
  for (int i = 0; i < 600; ++i) ++counts[std::stoi(dice.at(i / 600.0))];
  for (int k = 1; k <= 6; ++k) EXPECT_EQ(counts[k], 100);
  const Axis rate{.key = "a", .low = 1e-4, .high = 1.0, .logarithmic = true};
  EXPECT_EQ(rate.at(0.0), "0.0001");
  EXPECT_EQ(rate.at(0.5), "0.01");
  EXPECT_EQ(rate.at(0.25), "0.001");
}

TEST(Axis, SaysWhereAndWhatIsWrong) {
  EXPECT_EQ(message_of("a = { range = [0, 1], values = [1] }"),
            "s.toml:2: axes: a: expected one of values, range and log_range");
  EXPECT_EQ(message_of("\na = { range = [0, 1], cuont = 3 }"),
            "s.toml:3: axes: a: unknown key cuont; expected values, range, log_range, count or also");
  EXPECT_EQ(message_of("a = { range = [0, \"1\"] }"),
            "s.toml:2: axes: a: expected a range of two numbers, found [0, \"1\"]");
  EXPECT_EQ(message_of("a = { range = [nan, 1.0] }").substr(0, 49),
            "s.toml:2: axes: a: expected a range that rises, f");
  EXPECT_EQ(message_of("a = 3"), "s.toml:2: axes: a: expected a list of at least one value, found 3");
}

}  // namespace
}  // namespace s2nnds
