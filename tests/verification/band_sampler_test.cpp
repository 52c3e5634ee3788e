// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/band_sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

NetworkWeights linear(const Points& weight, double bias) {
  return {
      .layers = {{.weight = weight, .bias = Vector::Constant(1, bias), .activation = Activation::identity}}};
}

// A barrier whose zero set bends, on [-1, 1]^2.
NetworkWeights curved() {
  RandomStream random(5, "test");
  Layer hidden{.weight = Points(12, 2), .bias = Vector(12), .activation = Activation::tanh};
  Layer output{.weight = Points(1, 12), .bias = Vector::Constant(1, 0.1), .activation = Activation::identity};
  for (double& value : hidden.weight.reshaped()) value = 2.0 * random.normal();
  for (double& value : hidden.bias) value = random.normal();
  for (double& value : output.weight.reshaped()) value = random.normal();
  return {.layers = {hidden, output}};
}

TEST(BandSampler, DrawsUniformPointsOfTheBandAlone) {
  const BandSampler sampler(linear(Points{{1.0, 2.0}}, -0.5), Box::cube(2, 1.0), 0.01);
  RandomStream random(1, "test");
  const Points x = sampler.sample(20000, random);
  ASSERT_EQ(x.rows(), 20000);
  const Vector level = (x * Vector{{1.0, 2.0}}).array() - 0.5;
  EXPECT_LE(level.cwiseAbs().maxCoeff(), 0.01 + 1e-15);
  // B is uniform in the band, x1 on [-1, 1]: means within five standard deviations (a false alarm in 1e6
  // each).
  EXPECT_NEAR(level.mean(), 0.0, 5 * 0.01 / std::sqrt(3.0 * 20000));
  EXPECT_NEAR(x.col(0).mean(), 0.0, 5 / std::sqrt(3.0 * 20000));
  EXPECT_NEAR(x.col(0).array().square().mean(), 1.0 / 3.0, 5 * 0.3 / std::sqrt(20000.0));
}

TEST(BandSampler, TheCoverIsTight) {
  const BandSampler sampler(linear(Points{{1.0, 2.0}}, -0.5), Box::cube(2, 1.0), 0.01);
  EXPECT_GE(sampler.cover_volume(), 0.02);  // the band's: 0.01 across in x2, 2 along x1
  EXPECT_LT(sampler.cover_volume(), 0.06);
}

// Plain rejection from the whole box has the law that the sampler must have: the shares of 64 cells agree.
TEST(BandSampler, LeavesNoPartOfACurvedBandOut) {
  const NetworkWeights B = curved();
  const double band = 0.05;
  const BandSampler sampler(B, Box::cube(2, 1.0), band);
  RandomStream random(2, "test");
  Points plain(400000, 2);
  for (double& value : plain.reshaped()) value = random.uniform(-1.0, 1.0);
  const Vector level = B.value(plain).col(0);
  Eigen::ArrayXd expected = Eigen::ArrayXd::Zero(64);
  Eigen::ArrayXd found = Eigen::ArrayXd::Zero(64);
  const auto cell = [](double x1, double x2) {
    return 8 * std::min(7, static_cast<int>((x1 + 1) * 4)) + std::min(7, static_cast<int>((x2 + 1) * 4));
  };
  for (Eigen::Index i = 0; i < plain.rows(); ++i) {
    if (std::abs(level[i]) <= band) expected[cell(plain(i, 0), plain(i, 1))] += 1;
  }
  const auto total = static_cast<std::int64_t>(expected.sum());
  ASSERT_GT(total, 1000);
  const Points x = sampler.sample(total, random);
  ASSERT_EQ(x.rows(), total);
  for (Eigen::Index i = 0; i < x.rows(); ++i) found[cell(x(i, 0), x(i, 1))] += 1;
  // Differences of two Poisson counts, six standard deviations in each of 64 cells: a false alarm in 1e7.
  for (int i = 0; i < 64; ++i) {
    EXPECT_LE(std::abs(found[i] - expected[i]), 6 * std::sqrt(found[i] + expected[i] + 1)) << i;
  }
  EXPECT_LT(sampler.cover_volume(), 3.0 * 4.0 * static_cast<double>(total) / 400000);
}

TEST(BandSampler, FindsNothingWhereThereIsNoBand) {
  RandomStream random(1, "test");
  const BandSampler none(linear(Points{{0.1, 0.0}}, -1.0), Box::cube(2, 1.0), 0.1);
  EXPECT_EQ(none.cover_volume(), 0.0);
  EXPECT_EQ(none.sample(100, random).rows(), 0);
  const BandSampler thin(linear(Points{{1.0, 0.0}}, -0.3), Box::cube(2, 1.0), 1e-12);
  EXPECT_LT(thin.sample(100, random).rows(), 100);
}

// One draw in 5,000 hits this band: known early on, so that nobody waits for the fifty million draws which
// would find a fifth of the points.
TEST(BandSampler, GivesUpEarlyOnABandThatIsTooThinByFar) {
  const BandSampler thin(linear(Points{{1.0, 0.0}}, -0.3), Box::cube(2, 1.0), 5e-8);
  const double share = 4 * 5e-8 / thin.cover_volume();
  EXPECT_GT(share, 1.0 / 20000);
  EXPECT_LT(share, 1.0 / 2500);
  RandomStream random(3, "test");
  const Points x = thin.sample(50000, random);
  EXPECT_GT(x.rows(), 0);
  EXPECT_LT(x.rows(), 1000);
}

TEST(BandSampler, RefusesMisuse) {
  EXPECT_THROW(BandSampler(linear(Points{{1.0, 0.0}}, 0.0), Box::cube(3, 1.0), 0.1), Error);
  EXPECT_THROW(BandSampler(linear(Points{{1.0, 0.0}}, 0.0), Box::cube(2, INFINITY), 0.1), Error);
  EXPECT_THROW(BandSampler(linear(Points{{1.0, 0.0}}, 0.0), Box::cube(2, 1.0), std::nan("")), Error);
}

}  // namespace
}  // namespace s2nnds
