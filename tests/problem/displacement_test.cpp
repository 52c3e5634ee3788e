// SPDX-License-Identifier: BSD-3-Clause
// The change of coordinates that moves an obstacle, and the balls that it needs.
#include "s2nnds/problem/displacement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/problem/enclosing_ball.h"
#include "s2nnds/problem/extruded_region.h"
#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

Vector center_in(Eigen::Index n) { return Vector::LinSpaced(n, 0.1, -0.3); }
Displacement displacement_in(Eigen::Index n) { return {center_in(n), 0.2, 0.7}; }

Vector random_direction(Eigen::Index n, RandomStream& random) {
  Vector p = Vector::NullaryExpr(n, [&] { return random.normal(); });
  return p.normalized();
}

class DisplacementIn : public testing::TestWithParam<int> {
 protected:
  Eigen::Index n_ = GetParam();
  RandomStream random_{3, "displacement"};
  Displacement displacement_ = displacement_in(n_);
  // Every other one near the center.
  Points anywhere(Eigen::Index count) {
    Points x = Points::NullaryExpr(count, n_, [&] { return random_.uniform(-1.0, 1.0); });
    for (Eigen::Index k = 0; k < count; k += 2)
      x.row(k) = 0.3 * x.row(k) + displacement_.center().transpose();
    return x;
  }
};

TEST_P(DisplacementIn, InverseIsExactToRounding) {
  for (const double stretch : {0.1, 0.8, 0.95, 0.999}) {
    const Vector p = displacement_.largest(stretch) * random_direction(n_, random_);
    const Points x = anywhere(20000), y = displacement_.preimage(x, p);
    EXPECT_LE((displacement_.image(y, p) - x).cwiseAbs().maxCoeff(), 1e-12) << stretch;
    EXPECT_LE((displacement_.preimage(displacement_.image(x, p), p) - x).cwiseAbs().maxCoeff(), 1e-12)
        << stretch;
  }
}

TEST_P(DisplacementIn, MovesTheBallAsItIsAndNothingOutside) {
  const Vector p = displacement_.largest(0.8) * random_direction(n_, random_);
  const Points x = anywhere(20000), v = anywhere(20000);
  const Points image = displacement_.image(x, p), before = displacement_.preimage(x, p);
  const Points pushed = displacement_.pushed(x, v, p);
  Eigen::Index inside = 0, outside = 0;
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    const double distance = (x.row(k).transpose() - displacement_.center()).norm();
    if (distance <= displacement_.inner()) {
      ++inside;
      EXPECT_EQ((image.row(k) - (x.row(k) + p.transpose())).norm(), 0.0);
      EXPECT_EQ((pushed.row(k) - v.row(k)).norm(), 0.0);
    } else if (distance > displacement_.outer()) {
      ++outside;
      for (const Points* same : {&image, &before})
        EXPECT_EQ(
            std::memcmp(same->row(k).data(), x.row(k).data(), sizeof(double) * static_cast<std::size_t>(n_)),
            0);
      EXPECT_EQ(
          std::memcmp(pushed.row(k).data(), v.row(k).data(), sizeof(double) * static_cast<std::size_t>(n_)),
          0);
    }
  }
  EXPECT_GT(inside, 0);
  EXPECT_GT(outside, 1000);
}

TEST_P(DisplacementIn, NoDisplacementChangesNothingBitForBit) {
  const Points x = anywhere(1000), v = anywhere(1000);
  const Vector none = Vector::Zero(n_);
  for (const Points& same : {displacement_.image(x, none), displacement_.preimage(x, none)})
    EXPECT_EQ(std::memcmp(same.data(), x.data(), sizeof(double) * static_cast<std::size_t>(x.size())), 0);
  const Points pushed = displacement_.pushed(x, v, none);
  EXPECT_EQ(std::memcmp(pushed.data(), v.data(), sizeof(double) * static_cast<std::size_t>(v.size())), 0);
}

TEST_P(DisplacementIn, PushesVelocitiesAsDifferencesDo) {
  const Vector p = displacement_.largest(0.8) * random_direction(n_, random_);
  const Points y = anywhere(5000), v = anywhere(5000);
  constexpr double h = 1e-5;
  const Points difference =
      (displacement_.image(y + h * v, p) - displacement_.image(y - h * v, p)) / (2.0 * h);
  EXPECT_LE((difference - displacement_.pushed(y, v, p)).cwiseAbs().maxCoeff(), 1e-7);
}

TEST_P(DisplacementIn, LipschitzConstantIsSoundAndAttained) {
  const Points x = anywhere(200000);
  Points near = anywhere(200000);
  for (Eigen::Index k = 0; k < x.rows(); ++k) near.row(k) = x.row(k) + 1e-6 * near.row(k).normalized();
  const Vector change = displacement_.bump(x) - displacement_.bump(near);
  const double steepest = change.cwiseAbs().maxCoeff() / 1e-6;
  EXPECT_LE(steepest, displacement_.lipschitz() * (1.0 + 1e-6));
  EXPECT_GE(steepest, 0.95 * displacement_.lipschitz());
}

INSTANTIATE_TEST_SUITE_P(Dimensions, DisplacementIn, testing::Values(1, 2, 3, 5));

TEST(Displacement, LeavesThePhaseAlone) {
  const Displacement displacement = displacement_in(2);
  const Vector p = displacement.largest(0.8) * (Vector(2) << 0.6, 0.8).finished();
  RandomStream random(5, "phase");
  const Points x = Points::NullaryExpr(1000, 3, [&] { return random.uniform(-1.0, 1.0); });
  EXPECT_EQ(displacement.image(x, p).col(2), x.col(2));
  EXPECT_EQ((displacement.image(x, p).leftCols(2) - displacement.image(x.leftCols(2), p)).norm(), 0.0);
  EXPECT_EQ(displacement.pushed(x, x, p).col(2), x.col(2));
}

TEST(Displacement, RefusesRadiiAndDisplacementsThatAreNoChangeOfCoordinates) {
  const Vector center = Vector::Zero(2);
  EXPECT_THROW(Displacement(center, 0.5, 0.5), Error);
  EXPECT_THROW(Displacement(center, -0.1, 0.5), Error);
  EXPECT_THROW(Displacement(center, 0.1, std::nan("")), Error);
  const Displacement displacement(center, 0.1, 0.5);
  const Points x = Points::Zero(1, 2);
  EXPECT_THROW(displacement.preimage(x, Vector::Constant(2, 0.3)), Error);
  EXPECT_THROW(displacement.preimage(x, Vector::Constant(2, std::nan(""))), Error);
  EXPECT_THROW(displacement.preimage(x, Vector::Zero(3)), Error);
}

// Every point that a sampler finds lies in the ball, and the ball is hardly larger than it must be.
void expect_enclosed(const RegionPtr& region, double radius, double slack) {
  const Eigen::Index n = region->dimension();
  const Box within = Box::cube(n, 2.0);
  const auto found = enclosing_ball(*region, within, n);
  ASSERT_TRUE(found.has_value()) << region->describe();
  RandomStream random(7, "enclosing-ball");
  const Points points = RegionSampler(region, within).sample(20000, random);
  EXPECT_LE((points.rowwise() - found->center.transpose()).rowwise().norm().maxCoeff(), found->radius);
  EXPECT_GE(found->radius, radius * (1.0 - 1e-12)) << region->describe();
  EXPECT_LE(found->radius, radius * (1.0 + slack)) << region->describe();
}

TEST(EnclosingBall, HoldsTheRegionNearlyTightly) {
  const Vector middle = (Vector(2) << -0.4, 0.35).finished();
  expect_enclosed(ball(middle, 0.1), 0.1, 0.01);
  expect_enclosed(box_region({(Vector(2) << -0.4, -0.1).finished(), (Vector(2) << -0.3, 0.05).finished()}),
                  0.5 * std::hypot(0.1, 0.15), 0.01);
  expect_enclosed(ellipsoid(middle, (Vector(2) << 0.3, 0.1).finished()), 0.3, 0.01);
  // A triangle whose box is larger than it: the circle around (-0.4, 0), (-0.2, 0), (-0.3, -0.5).
  expect_enclosed(expression("max(y, -4*x - 0.8*y - 1.6, 4*x - 0.8*y + 0.8)", 2), 0.26, 0.02);
  expect_enclosed(unite({ball(middle, 0.1), ball(-middle, 0.1)}), middle.norm() + 0.1, 0.01);
  expect_enclosed(ball((Vector(3) << 0.1, 0.2, -0.3).finished(), 0.25), 0.25, 0.05);
}

TEST(EnclosingBall, OfStatesWithAPhaseCountsPlacesAlone) {
  const Vector middle = (Vector(2) << 0.4, -0.3).finished();
  const RegionPtr region = extruded(ball(middle, 0.2));
  Box within = Box::cube(3, 2.0);
  within.upper[2] = 5.0;
  const auto found = enclosing_ball(*region, within, 2);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->radius, 0.2, 0.002);
  EXPECT_NEAR((found->center - middle).norm(), 0.0, 0.002);
  EXPECT_NEAR(distance_below(*region, within, Vector::Zero(2)), 0.3, 0.001);
}

TEST(EnclosingBall, RefusesWhatIsNotThereOrNotBounded) {
  const Box within = Box::cube(2, 2.0);
  EXPECT_FALSE(enclosing_ball(*empty_region(2), within, 2).has_value());
  EXPECT_FALSE(enclosing_ball(*complement(ball(Vector::Zero(2), 0.1)), within, 2).has_value());
  EXPECT_THROW(enclosing_ball(*empty_region(2), within, 3), Error);
  EXPECT_EQ(distance_below(*empty_region(2), within, Vector::Zero(2)), HUGE_VAL);
}

TEST(EnclosingBall, DistanceIsNeverTooLarge) {
  RandomStream random(9, "distance");
  const Box within = Box::cube(2, 1.25);
  for (int k = 0; k < 20; ++k) {
    const Vector middle = Vector::NullaryExpr(2, [&] { return random.uniform(-0.6, 0.6); });
    const Vector center = Vector::NullaryExpr(2, [&] { return random.uniform(-1.0, 1.0); });
    const double exact = (middle - center).norm() - 0.15;
    const double found = distance_below(*ball(middle, 0.15), within, center);
    EXPECT_LE(found, std::max(0.0, exact) + 1e-15);
    EXPECT_GE(found, std::max(0.0, exact) - 0.001);
  }
}

}  // namespace
}  // namespace s2nnds
