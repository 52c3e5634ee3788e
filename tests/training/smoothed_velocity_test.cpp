// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/smoothed_velocity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// The field that the demonstrations below follow, a spiral towards the origin.
Points truth(const Points& x) {
  Points v(x.rows(), 2);
  v.col(0) = -0.6 * x.col(0) - 0.8 * x.col(1);
  v.col(1) = 0.8 * x.col(0) - 0.6 * x.col(1);
  return v;
}

// Motions from neighbouring starts, each `amount` faster or slower than the truth, in turn, by a slow wave.
std::vector<Demonstration> spirals(int count, double amount) {
  std::vector<Demonstration> all;
  for (int k = 0; k < count; ++k) {
    Demonstration d;
    d.time = Vector::LinSpaced(400, 0.0, 4.0);
    const Vector radius = (0.9 + 0.02 * k) * (-0.6 * d.time.array()).exp();
    d.position.resize(400, 2);
    d.position.col(0) = radius.array() * (0.8 * d.time.array()).cos();
    d.position.col(1) = radius.array() * (0.8 * d.time.array()).sin();
    const Vector wave = amount * (1.5 * d.time.array() + 2.4 * k).sin();
    d.velocity = truth(d.position).array().colwise() * (1.0 + wave.array());
    all.push_back(d);
  }
  return all;
}

double rms_error(const std::vector<Demonstration>& all) {
  return std::sqrt((stack_velocities(all) - truth(stack_positions(all))).rowwise().squaredNorm().mean());
}

TEST(SmoothedVelocity, BringsWhatDemonstrationsDoEachByItselfNearerToWhatTheyShare) {
  const std::vector<Demonstration> raw = spirals(6, 0.4);
  const std::vector<Demonstration> smooth = smoothed(raw, 1.0);
  EXPECT_LT(rms_error(smooth), 0.5 * rms_error(raw));
  EXPECT_EQ(stack_positions(smooth), stack_positions(raw));
}

TEST(SmoothedVelocity, HardlyChangesDemonstrationsThatAgree) {
  const std::vector<Demonstration> raw = spirals(5, 0.0);
  EXPECT_LT(rms_error(smoothed(raw, 1.0)), 0.01);
}

TEST(SmoothedVelocity, TheShareBlends) {
  const std::vector<Demonstration> raw = spirals(3, 0.3);
  const Points v = stack_velocities(raw), whole = stack_velocities(smoothed(raw, 1.0)),
               quarter = stack_velocities(smoothed(raw, 0.25));
  EXPECT_LT((quarter - (v + 0.25 * (whole - v))).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(stack_velocities(smoothed(raw, 0.0)), v);
}

TEST(SmoothedVelocity, LeavesMotionsThatLieFarApartAsTheyAre) {
  std::vector<Demonstration> raw = spirals(4, 0.3);
  for (std::size_t k = 0; k < raw.size(); ++k) raw[k].position.col(0).array() += static_cast<double>(k);
  EXPECT_EQ(stack_velocities(smoothed(raw, 1.0)), stack_velocities(raw));
}

TEST(SmoothedVelocity, LeavesASingleDemonstrationAsItIs) {
  const std::vector<Demonstration> raw = spirals(1, 0.3);
  EXPECT_EQ(stack_velocities(smoothed(raw, 1.0)), stack_velocities(raw));
}

TEST(SmoothedVelocity, TakesManyDemonstrationsAndShortOnes) {
  std::vector<Demonstration> raw = spirals(30, 0.2);
  for (Demonstration& d : raw) {
    d = {d.time.head(7), d.position.topRows(7), d.velocity.topRows(7)};
  }
  EXPECT_TRUE(stack_velocities(smoothed(raw, 1.0)).allFinite());
  EXPECT_LT(rms_error(smoothed(spirals(30, 0.2), 1.0)), 0.5 * rms_error(spirals(30, 0.2)));
}

TEST(SmoothedVelocity, RefusesAShareThatIsNone) {
  EXPECT_THROW(smoothed(spirals(2, 0.1), 1.1), Error);
  EXPECT_THROW(smoothed(spirals(2, 0.1), -0.1), Error);
  EXPECT_THROW(smoothed(spirals(2, 0.1), std::nan("")), Error);
}

}  // namespace
}  // namespace s2nnds
