// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/split.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "s2nnds/data/handwriting.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

TEST(Split, HoldsOutWholeDemonstrations) {
  const Split split = split_demonstrations(7, {6, 0});
  EXPECT_EQ(split.test, (std::vector<std::int64_t>{6, 0}));
  EXPECT_EQ(split.train, (std::vector<std::int64_t>{1, 2, 3, 4, 5}));
  EXPECT_EQ(split_demonstrations(2, {}).train, (std::vector<std::int64_t>{0, 1}));
  const Split three = split_demonstrations(7, {5, 6}, {4, 0});
  EXPECT_EQ(three.train, (std::vector<std::int64_t>{1, 2, 3}));
  EXPECT_EQ(three.validation, (std::vector<std::int64_t>{4, 0}));
}

TEST(Split, AShareLeavesSmallSetsWhole) {
  const auto test = [](std::size_t count) { return split_demonstrations(count, {kTestByShare}).test; };
  for (const std::size_t count : {1, 2, 3}) EXPECT_TRUE(test(count).empty());
  EXPECT_EQ(test(4), (std::vector<std::int64_t>{3}));
  EXPECT_EQ(test(7), (std::vector<std::int64_t>{6}));
  EXPECT_EQ(test(10), (std::vector<std::int64_t>{8, 9}));
  const Split three = split_demonstrations(5, {kTestByShare}, {4});
  EXPECT_EQ(three.test, (std::vector<std::int64_t>{3}));
  EXPECT_EQ(three.train, (std::vector<std::int64_t>{0, 1, 2}));
}

TEST(Split, BadIndicesAreRejected) {
  expect_error([] { split_demonstrations(7, {7}); }, "found index 7; expected 0 to 6");
  expect_error([] { split_demonstrations(7, {-1, 2}); }, "found index -1");
  expect_error([] { split_demonstrations(7, {2, 2}); }, "found index 2 twice");
  expect_error([] { split_demonstrations(7, {2}, {2}); }, "found index 2 twice");
  expect_error([] { split_demonstrations(2, {1, 0}); }, "expected at least 1 left");
}

TEST(Split, SelectKeepsTheOrderAskedFor) {
  const std::vector<Demonstration> all = handwriting("N").demonstrations;
  const std::vector<Demonstration> chosen = select(all, {4, 1});
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0].position, all[4].position);
  EXPECT_EQ(chosen[1].position, all[1].position);
  expect_error([&] { select(all, {9}); }, "found index 9; expected 0 to 6");
}

}  // namespace
}  // namespace s2nnds
