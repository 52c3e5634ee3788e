// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/region_sampler.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <set>
#include <utility>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

TEST(RegionSampler, PointsAreUniform) {
  // An annulus, whose cells of equal area are known: 10 rings of equal area times 12 sectors.
  const double inner = 0.3, outer = 0.8;
  const RegionPtr annulus =
      intersect({ball(Vector{{0.1, -0.2}}, outer), complement(ball(Vector{{0.1, -0.2}}, inner))});
  const RegionSampler sampler(annulus, Box::cube(2, 1.25));
  RandomStream random(1, "sampler");
  constexpr int kCount = 120000, kRings = 10, kSectors = 12;
  const Points x = sampler.sample(kCount, random);
  ASSERT_EQ(x.rows(), kCount);
  std::vector<int> counts(kRings * kSectors);
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    const double dx = x(k, 0) - 0.1, dy = x(k, 1) + 0.2;
    const double share = (dx * dx + dy * dy - inner * inner) / (outer * outer - inner * inner);
    ASSERT_TRUE(share > -1e-9 && share < 1 + 1e-9);
    const int ring = std::clamp(static_cast<int>(share * kRings), 0, kRings - 1);
    const int sector =
        std::clamp(static_cast<int>((std::atan2(dy, dx) / M_PI + 1) / 2 * kSectors), 0, kSectors - 1);
    ++counts[static_cast<std::size_t>(ring * kSectors + sector)];
  }
  double statistic = 0.0;
  const double expected = static_cast<double>(kCount) / (kRings * kSectors);
  for (int count : counts) statistic += (count - expected) * (count - expected) / expected;
  // False alarm rate 1e-6 (for one seed: the test is deterministic).
  const boost::math::chi_squared law(kRings * kSectors - 1);
  EXPECT_LT(statistic, quantile(complement(law, 1e-6)));
}

TEST(RegionSampler, VolumesBracketTheTruth) {
  const RegionSampler sampler(ball(Vector{{1.0, 0.0}}, 0.5), Box::cube(2, 1.0));  // half of it lies within
  EXPECT_LT(sampler.volume_inside(), M_PI / 8);
  EXPECT_GT(sampler.volume_cover(), M_PI / 8);
  EXPECT_LT(sampler.volume_cover() - sampler.volume_inside(), 0.1 * M_PI / 8);
}

TEST(RegionSampler, TinyAndThinSetsAreSampled) {
  RandomStream random(2, "sampler");
  const RegionPtr tiny = ball(Vector{{0.123, -0.456}}, 1e-5);
  const RegionPtr thin = expression("max(y - x - 1e-6, x - y)", 2);
  const RegionPtr tiny_3d = ball(Vector{{0.1, 0.2, 0.3}}, 1e-3);
  for (const RegionPtr& region : {tiny, thin, tiny_3d}) {
    const RegionSampler sampler(region, Box::cube(region->dimension(), 1.25));
    ASSERT_FALSE(sampler.empty()) << region->describe();
    const Points x = sampler.sample(20, random);
    EXPECT_LE(region->level(x).maxCoeff(), 0.0) << region->describe();
    EXPECT_GT((x.rowwise() - x.row(0)).rowwise().norm().maxCoeff(), 0.0);
  }
}

TEST(RegionSampler, EmptySetsAreNoticed) {
  RandomStream random(3, "sampler");
  for (const RegionPtr& region :
       {empty_region(2), ball(Vector{{3.0, 3.0}}, 0.5), expression("x^2 + y^2 + 1e-6", 2),
        box_region({Vector{{0.0, 0.5}}, Vector{{1.0, 0.5}}}),  // a segment has no volume
        intersect({halfspace(Vector{{1.0, 1.0}}, 0.0), halfspace(Vector{{-1.0, -1.0}}, -1e-3)})}) {
    const RegionSampler sampler(region, Box::cube(2, 1.0));
    EXPECT_TRUE(sampler.empty()) << region->describe();
    EXPECT_EQ(sampler.volume_cover(), 0.0);
    EXPECT_THROW(sampler.sample(1, random), Error);
  }
  EXPECT_THROW(RegionSampler(empty_region(2), Box::cube(3, 1.0)), Error);
  EXPECT_THROW(RegionSampler(empty_region(2), Box::cube(2, std::numeric_limits<double>::infinity())), Error);
}

TEST(RegionSampler, TheStreamDecidesThePoints) {
  const RegionSampler sampler(ball(Vector{{0.0, 0.0}}, 0.5), Box::cube(2, 1.0));
  RandomStream a(4, "sampler"), b(4, "sampler"), c(5, "sampler");
  const Points first = sampler.sample(100, a);
  EXPECT_EQ(first, sampler.sample(100, b));
  EXPECT_NE(first, sampler.sample(100, c));
  EXPECT_NE(first, sampler.sample(100, a));
  EXPECT_EQ(sampler.sample(0, a).rows(), 0);
}

TEST(RegionSampler, WithAStockOneInEightIsDrawnAnew) {
  RegionSampler sampler(ball(Vector{{0.1, -0.2}}, 0.5), Box::cube(2, 1.0));
  RandomStream random(2, "stock");
  sampler.keep_stock(100, random);
  const Points x = sampler.sample(800, random);
  ASSERT_EQ(x.rows(), 800);
  std::set<std::pair<double, double>> places;
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    EXPECT_LE(std::hypot(x(k, 0) - 0.1, x(k, 1) + 0.2), 0.5);
    places.emplace(x(k, 0), x(k, 1));
  }
  EXPECT_LE(places.size(), 200u);
  EXPECT_GT(places.size(), 150u);
}

}  // namespace
}  // namespace s2nnds
