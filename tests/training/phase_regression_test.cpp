// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/phase_regression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// Half a turn about the origin at radius r and angular velocity `speed`, clockwise; sampled at a rate that
// varies by `warp` along the way, so that equal shares of the samples are not equal shares of the way.
Demonstration arc(double r, double speed, double warp, Eigen::Index samples = 200) {
  Demonstration d;
  const Vector u = Vector::LinSpaced(samples, 0.0, 1.0);
  const Vector turned = u.array() + warp * (std::numbers::pi * u.array()).sin() / std::numbers::pi;
  const Vector angle = std::numbers::pi * (1.0 - turned.array());
  d.time = turned * std::numbers::pi / speed;
  d.position.resize(samples, 2);
  d.position.col(0) = r * angle.array().cos();
  d.position.col(1) = r * angle.array().sin();
  d.velocity.resize(samples, 2);
  d.velocity.col(0) = speed * d.position.col(1);
  d.velocity.col(1) = -speed * d.position.col(0);
  return d;
}

Points at(double x, double y) {
  Points point(1, 2);
  point << x, y;
  return point;
}

Demonstration turned(Demonstration d, double angle) {
  Eigen::Matrix2d rotation;
  rotation << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  d.position *= rotation;
  d.velocity *= rotation;
  return d;
}

TEST(PhaseRegression, IsTheMeanOfTheDemonstrationsWhereTheyDiffer) {
  const PhaseRegression g({arc(0.5, 1.2, 0.0), arc(0.5, 0.8, 0.0)});
  const Points v = g.velocity(at(0.0, 0.5));
  EXPECT_NEAR(v(0, 0), 0.5, 0.01);
  EXPECT_NEAR(v(0, 1), 0.0, 0.01);
}

TEST(PhaseRegression, ComparesEqualPlacesOfTheMotionHoweverTheyWereSampled) {
  const std::vector<Demonstration> all = {arc(0.5, 1.0, 0.0), arc(0.52, 1.0, 0.6), arc(0.48, 1.0, -0.6, 90)};
  const PhaseRegression g(all);
  for (double angle = 0.3; angle < 2.9; angle += 0.2) {
    const double x = 0.5 * std::cos(angle), y = 0.5 * std::sin(angle);
    EXPECT_LT((g.velocity(at(x, y)) - at(y, -x)).norm(), 0.03) << angle;
  }
}

TEST(PhaseRegression, TurnsWithTheMotion) {
  const std::vector<Demonstration> all = {arc(0.5, 1.0, 0.2), arc(0.6, 1.1, -0.3), arc(0.55, 0.9, 0.1)};
  std::vector<Demonstration> rotated;
  for (const Demonstration& each : all) rotated.push_back(turned(each, 0.7));
  const Demonstration probe = arc(0.57, 1.0, 0.0, 20);
  const Demonstration expected =
      turned({probe.time, probe.position, PhaseRegression(all).velocity(probe.position)}, 0.7);
  const Points found = PhaseRegression(rotated).velocity(expected.position);
  EXPECT_LT((found - expected.velocity).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(PhaseRegression, IsFiniteFarAwayAndForDemonstrationsThatAreEqual) {
  const PhaseRegression g({arc(0.5, 1.0, 0.0, 2), arc(0.5, 1.0, 0.0, 2)});
  for (const double far : {0.0, 1.0, 1e6}) EXPECT_TRUE(g.velocity(at(far, -far)).allFinite()) << far;
}

TEST(PhaseRegression, RefusesASingleDemonstration) {
  EXPECT_THROW(PhaseRegression({arc(0.5, 1.0, 0.0)}), Error);
}

}  // namespace
}  // namespace s2nnds
