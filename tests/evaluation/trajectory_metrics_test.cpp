// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/trajectory_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

Points random_curve(Eigen::Index rows, std::uint64_t seed) {
  RandomStream random(seed, "test");
  Points curve(rows, 2);
  for (double& value : curve.reshaped()) value = random.normal();
  return curve;
}

TEST(VelocityErrors, KnownAnswers) {
  const Points velocity{{0.0, 0.0}, {1.0, 0.0}};
  const Points predicted{{3.0, 4.0}, {1.0, 1.0}};  // errors 5 and 1
  EXPECT_DOUBLE_EQ(mean_squared_error(predicted, velocity), 13.0);
  EXPECT_DOUBLE_EQ(error_deviation(predicted, velocity), 2.0);
}

TEST(VelocityErrors, RefuseOtherShapes) {
  EXPECT_THROW(mean_squared_error(Points::Zero(2, 2), Points::Zero(3, 2)), Error);
  EXPECT_THROW(error_deviation(Points::Zero(2, 2), Points::Zero(2, 3)), Error);
  EXPECT_THROW(mean_squared_error(Points(0, 2), Points(0, 2)), Error);
}

TEST(Dtw, KnownAnswersByHand) {
  const Points ramp{{0.0}, {2.0}};
  const Points fine{{0.0}, {1.0}, {2.0}};
  EXPECT_DOUBLE_EQ(dtw(ramp, fine), 1.0 / 3.0);  // 0, 1, 0 along three pairs
  EXPECT_DOUBLE_EQ(dtw_independent(ramp, fine), 1.0);
  const Points line{{0.0, 0.0}, {1.0, 0.0}, {2.0, 0.0}};
  const Points raised{{0.0, 0.5}, {1.0, 0.5}, {2.0, 0.5}};
  EXPECT_DOUBLE_EQ(dtw(line, raised), 0.5);
  EXPECT_DOUBLE_EQ(dtw_independent(line, raised), std::sqrt(0.75));
  EXPECT_DOUBLE_EQ(dtw(Points{{0.0, 0.0}}, Points{{3.0, 4.0}, {3.0, 4.0}}), 5.0);
}

TEST(Dtw, IsZeroOnWarpedCopiesOnly) {
  const Points curve = random_curve(30, 1);
  EXPECT_EQ(dtw(curve, curve), 0.0);
  EXPECT_EQ(dtw_independent(curve, curve), 0.0);
  Points slow(60, 2);
  for (Eigen::Index i = 0; i < 60; ++i) slow.row(i) = curve.row(i / 2);
  EXPECT_EQ(dtw(curve, slow), 0.0);
  EXPECT_GT(dtw(curve, random_curve(30, 2)), 0.0);
}

TEST(Dtw, IsSymmetric) {
  const Points a = random_curve(17, 3);
  const Points b = random_curve(25, 4);
  EXPECT_DOUBLE_EQ(dtw(a, b), dtw(b, a));
  EXPECT_DOUBLE_EQ(dtw_independent(a, b), dtw_independent(b, a));
}

TEST(Dtw, IndependentAxesWarpEachOnTheirOwn) {
  // Each axis makes the same jump, at different moments: warping them apart costs nothing, warping them
  // together does.
  const Points a{{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}};
  const Points b{{0.0, 0.0}, {0.0, 1.0}, {1.0, 1.0}};
  EXPECT_EQ(dtw_independent(a, b), 0.0);
  EXPECT_GT(dtw(a, b), 0.2);
}

TEST(Dtw, NotANumberShows) {
  Points a = random_curve(5, 1);
  a(2, 1) = std::nan("");
  EXPECT_TRUE(std::isnan(dtw(a, random_curve(5, 2))));
  EXPECT_TRUE(std::isnan(dtw_independent(random_curve(5, 2), a)));
}

NetworkWeights linear(const Points& weight, const Vector& bias = {}) {
  return {.layers = {{.weight = weight, .bias = bias, .activation = Activation::identity}}};
}

Demonstration decay(const Eigen::RowVector2d& start, double first_time) {
  Demonstration shown;
  shown.time = Vector::LinSpaced(400, first_time, first_time + 4.0);
  shown.position.resize(400, 2);
  for (Eigen::Index i = 0; i < 400; ++i) shown.position.row(i) = start * std::exp(first_time - shown.time[i]);
  shown.velocity = -shown.position;
  return shown;
}

TEST(MotionErrors, VanishForTheFieldThatMadeTheMotion) {
  const std::vector<Demonstration> shown = {decay({1.0, -0.5}, 0.0), decay({0.2, 0.9}, 3.0)};
  const MotionErrors errors = motion_errors(linear(-Points::Identity(2, 2)), shown);
  EXPECT_LT(errors.mse, 1e-30);
  EXPECT_LT(errors.sd, 1e-15);
  EXPECT_LT(errors.dtw, 1e-5);
  EXPECT_LT(errors.dtw_independent, 1e-4);
}

TEST(MotionErrors, MeasureAConstantError) {
  const std::vector<Demonstration> shown = {decay({1.0, -0.5}, 0.0)};
  // f = -x + (0.3, 0.4): the velocity is off by 0.5 everywhere, the motion ends at (0.3, 0.4).
  const MotionErrors errors = motion_errors(linear(-Points::Identity(2, 2), Vector{{0.3, 0.4}}), shown);
  EXPECT_NEAR(errors.mse, 0.25, 1e-12);
  EXPECT_NEAR(errors.sd, 0.0, 1e-7);
  EXPECT_GT(errors.dtw, 0.1);
  EXPECT_LT(errors.dtw, 0.5);
}

TEST(MotionErrors, OfNoDemonstrationsAreNotNumbers) {
  const MotionErrors errors = motion_errors(linear(-Points::Identity(2, 2)), {});
  EXPECT_TRUE(std::isnan(errors.mse) && std::isnan(errors.sd) && std::isnan(errors.dtw));
}

}  // namespace
}  // namespace s2nnds
