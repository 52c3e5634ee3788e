// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "s2nnds/core/check.h"

// The seeds are fixed, so these tests cannot fail by chance; the bounds are five standard deviations, so that
// a right generator would have passed with probability above 0.999999 a bound.
namespace s2nnds {
namespace {

constexpr int kDraws = 200000;

std::vector<double> draws(RandomStream stream, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(stream.uniform());
  return values;
}

TEST(RandomStream, TheSameNameGivesTheSameNumbers) {
  EXPECT_EQ(draws(RandomStream(7, "workspace", 3), 100), draws(RandomStream(7, "workspace", 3), 100));
}

// Streams must stay the same between releases, since run files store only the seed. (std::mt19937_64 is fixed
// by the C++ standard; the key is ours.)
TEST(RandomStream, SeedNameAndIndexAllMatter) {
  std::set<double> firsts;
  int streams = 0;
  for (std::uint64_t seed : {0, 1, 2}) {
    for (const char* name : {"a", "b", "ab", "ba", "aa", "conformal"}) {
      for (std::uint64_t index : {0, 1, 2}) {
        firsts.insert(RandomStream(seed, name, index).uniform());
        ++streams;
      }
    }
  }
  EXPECT_EQ(firsts.size(), static_cast<std::size_t>(streams));
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - 0.5) * (b[i] - 0.5);
  return sum / static_cast<double>(a.size()) * 12.0;
}

TEST(RandomStream, StreamsAreUncorrelated) {
  const double bound = 5.0 / std::sqrt(kDraws);
  const auto base = draws(RandomStream(1, "pool", 0), kDraws);
  EXPECT_LT(std::abs(correlation(base, draws(RandomStream(2, "pool", 0), kDraws))), bound);
  EXPECT_LT(std::abs(correlation(base, draws(RandomStream(1, "poom", 0), kDraws))), bound);
  EXPECT_LT(std::abs(correlation(base, draws(RandomStream(1, "pool", 1), kDraws))), bound);
  EXPECT_NEAR(correlation(base, base), 1.0, 0.01);
}

TEST(RandomStream, UniformFillsItsIntervalEvenly) {
  RandomStream stream(3, "uniform");
  std::vector<int> bins(20, 0);
  for (int i = 0; i < kDraws; ++i) {
    const double value = stream.uniform(-2.0, 3.0);
    ASSERT_TRUE(value >= -2.0 && value < 3.0);
    ++bins[static_cast<std::size_t>((value + 2.0) / 5.0 * 20.0)];
  }
  const double mean = kDraws / 20.0;
  for (int count : bins) EXPECT_NEAR(count, mean, 5.0 * std::sqrt(mean));
}

TEST(RandomStream, NormalHasTheMomentsOfTheNormalLaw) {
  RandomStream stream(4, "normal");
  double sum = 0.0;
  double squares = 0.0;
  double fourths = 0.0;
  int beyond = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = stream.normal();
    sum += z;
    squares += z * z;
    fourths += z * z * z * z;
    beyond += std::abs(z) > 1.959963984540054;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 5.0 / std::sqrt(kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0, 5.0 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(fourths / kDraws, 3.0, 5.0 * std::sqrt(96.0 / kDraws));
  EXPECT_NEAR(beyond, 0.05 * kDraws, 5.0 * std::sqrt(0.05 * 0.95 * kDraws));
}

TEST(RandomStream, BelowTakesEveryValueEquallyOften) {
  RandomStream stream(5, "below");
  std::vector<int> counts(7, 0);
  for (int i = 0; i < kDraws; ++i) ++counts.at(stream.below(7));
  for (int count : counts) EXPECT_NEAR(count, kDraws / 7.0, 5.0 * std::sqrt(kDraws / 7.0));
  EXPECT_EQ(stream.below(1), 0u);
  EXPECT_THROW(stream.below(0), Error);
}

}  // namespace
}  // namespace s2nnds
