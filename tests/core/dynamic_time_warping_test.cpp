// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/dynamic_time_warping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

using Pairs = std::vector<std::pair<Eigen::Index, Eigen::Index>>;

double least_cost(const Points& cost, Eigen::Index i, Eigen::Index j) {
  if (i < 0 || j < 0) return std::numeric_limits<double>::infinity();
  if (i == 0 && j == 0) return cost(0, 0);
  return cost(i, j) +
         std::min({least_cost(cost, i - 1, j - 1), least_cost(cost, i - 1, j), least_cost(cost, i, j - 1)});
}

TEST(Warp, FindsThePathByHand) {
  const WarpingPath path = warp(Points{{0.0, 9.0, 9.0}, {1.0, 9.0, 9.0}, {9.0, 2.0, 3.0}});
  EXPECT_DOUBLE_EQ(path.cost, 6.0);
  EXPECT_EQ(path.pairs, (Pairs{{2, 2}, {2, 1}, {1, 0}, {0, 0}}));
}

TEST(Warp, TakesTheShortestOfTheCheapestPaths) {
  EXPECT_EQ(warp(Points::Zero(3, 3)).pairs, (Pairs{{2, 2}, {1, 1}, {0, 0}}));
  EXPECT_EQ(warp(Points::Zero(2, 4)).pairs.size(), 4U);
}

TEST(Warp, OfOneSampleMatchesItWithAll) {
  EXPECT_EQ(warp(Points{{1.0, 2.0, 3.0}}).pairs, (Pairs{{0, 2}, {0, 1}, {0, 0}}));
  EXPECT_EQ(warp(Points{{1.0}, {2.0}}).pairs, (Pairs{{1, 0}, {0, 0}}));
}

TEST(Warp, NoPathOfRandomCostsIsCheaper) {
  RandomStream random(5, "test");
  for (int repetition = 0; repetition < 20; ++repetition) {
    Points cost(5, 6);
    for (double& value : cost.reshaped()) value = random.uniform(0.0, 1.0);
    const WarpingPath path = warp(cost);
    EXPECT_DOUBLE_EQ(path.cost, least_cost(cost, 4, 5));
    double sum = 0.0;
    for (const auto& [i, j] : path.pairs) sum += cost(i, j);
    EXPECT_NEAR(sum, path.cost, 1e-12);
  }
}

TEST(Warp, EndsAtTheStartEvenWhereAllIsInfinite) {
  const WarpingPath path = warp(Points::Constant(3, 2, std::numeric_limits<double>::infinity()));
  EXPECT_EQ(path.pairs.front(), (Pairs::value_type{2, 1}));
  EXPECT_EQ(path.pairs.back(), (Pairs::value_type{0, 0}));
}

TEST(Warp, RefusesAnEmptyCurve) { EXPECT_THROW(warp(Points(0, 3)), Error); }

}  // namespace
}  // namespace s2nnds
