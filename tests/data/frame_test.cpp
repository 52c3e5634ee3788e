// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/frame.h"

#include <gtest/gtest.h>

#include "s2nnds/data/handwriting.h"
#include "s2nnds/data/readers.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

// A demonstration that ends at (7, -1) and begins when the clock shows 2 s.
DemonstrationSet two_samples() {
  Demonstration d{Vector(2), Points(2, 2), Points(2, 2)};
  d.time << 2, 2.5;
  d.position << 4, 3, 7, -1;
  d.velocity << 6, -8, 0, 10;
  return {"two", "mm", {d}};
}

std::vector<Demonstration> normalized(const DemonstrationSet& set, const std::string& normalization) {
  return find_frame(set, normalization).normalize(set.demonstrations);
}

TEST(Frame, KnownScalesAndGoals) {
  const Frame abs = find_frame(two_samples(), "max_abs");
  EXPECT_EQ(abs.unit, "mm");
  EXPECT_EQ(abs.goals, (Points{{7, -1}}));
  EXPECT_DOUBLE_EQ(abs.position_scale, 4);
  EXPECT_DOUBLE_EQ(abs.velocity_scale, 10);
  const Frame norm = find_frame(two_samples(), "max_norm");
  EXPECT_DOUBLE_EQ(norm.position_scale, 5);
  EXPECT_DOUBLE_EQ(norm.velocity_scale, 10);
  EXPECT_DOUBLE_EQ(norm.time_scale(), 0.5);
}

TEST(Frame, EachDemonstrationEndsInTheOriginAndBeginsAtTimeZero) {
  DemonstrationSet set = two_samples();
  set.demonstrations.push_back(set.demonstrations[0]);
  set.demonstrations[1].position.rowwise() += Eigen::RowVector2d(100, 200);
  for (const Demonstration& d : normalized(set, "max_norm")) {
    EXPECT_EQ(d.time, (Vector{{0, 1}}));
    EXPECT_TRUE(d.position.isApprox(Points{{-0.6, 0.8}, {0, 0}}, 1e-15));
    EXPECT_TRUE(d.velocity.isApprox(Points{{0.6, -0.8}, {0, 1}}, 1e-15));
  }
}

TEST(Frame, TheLargestCoordinateOrNormIsOneOverAllDemonstrations) {
  const DemonstrationSet helix = handwriting("Helix");
  const std::vector<Demonstration> abs = normalized(helix, "max_abs");
  EXPECT_NEAR(stack_positions(abs).cwiseAbs().maxCoeff(), 1, 1e-15);
  EXPECT_NEAR(stack_velocities(abs).cwiseAbs().maxCoeff(), 1, 1e-15);
  const std::vector<Demonstration> norm = normalized(helix, "max_norm");
  EXPECT_NEAR(stack_positions(norm).rowwise().norm().maxCoeff(), 1, 1e-15);
  EXPECT_NEAR(stack_velocities(norm).rowwise().norm().maxCoeff(), 1, 1e-15);
}

TEST(Frame, VelocityStaysTheDerivativeOfPosition) {
  for (const Demonstration& d : normalized(handwriting("Sine"), "max_abs")) {
    EXPECT_LT((differentiate(d.time, d.position) - d.velocity).cwiseAbs().maxCoeff(), 1e-4);
  }
}

TEST(Frame, ScalingTheDataScalesTheScalesAndNothingElse) {
  const DemonstrationSet millimetres = handwriting("C");
  DemonstrationSet metres = millimetres;
  for (Demonstration& d : metres.demonstrations) {
    d.position /= 1024;
    d.velocity /= 1024;
  }
  const std::vector<Demonstration> a = normalized(millimetres, "max_norm");
  const std::vector<Demonstration> b = normalized(metres, "max_norm");
  EXPECT_TRUE(stack_positions(a).isApprox(stack_positions(b), 1e-14));
  EXPECT_TRUE(a[0].time.isApprox(b[0].time, 1e-14));
}

TEST(Frame, MisuseIsRejected) {
  DemonstrationSet still = two_samples();
  still.demonstrations[0].velocity.setZero();
  expect_error([&] { find_frame(still, "max_abs"); }, "expected a motion");
  expect_error([] { find_frame({"none", "", {}}, "max_abs"); }, "found no demonstrations");
  expect_error([] { find_frame(two_samples(), "largest"); }, "found 'largest'; expected max_abs or max_norm");
  expect_error([] { find_frame(two_samples(), "max_abs").normalize({}); },
               "found 0 demonstrations, expected 1");
}

}  // namespace
}  // namespace s2nnds
