// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/frame.h"

#include <gtest/gtest.h>

#include <cmath>

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

// A second demonstration, elsewhere.
DemonstrationSet two_places(double dx, double dy) {
  DemonstrationSet set = two_samples();
  set.demonstrations.push_back(set.demonstrations[0]);
  set.demonstrations[1].position.rowwise() += Eigen::RowVector2d(dx, dy);
  return set;
}

std::vector<Demonstration> normalized(const DemonstrationSet& set, const std::string& normalization) {
  return find_frame(set, normalization, {"each"}).normalize(set.demonstrations);
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
  for (const Demonstration& d : normalized(two_places(100, 200), "max_norm")) {
    EXPECT_EQ(d.time, (Vector{{0, 1}}));
    EXPECT_TRUE(d.position.isApprox(Points{{-0.6, 0.8}, {0, 0}}, 1e-15));
    EXPECT_TRUE(d.velocity.isApprox(Points{{0.6, -0.8}, {0, 1}}, 1e-15));
  }
}

TEST(Frame, WhereTheGoalLies) {
  const DemonstrationSet set = two_places(0.2, 0.3);
  const Frame mean = find_frame(set, "max_abs");
  EXPECT_TRUE(mean.goal.isApprox(Vector{{7.1, -0.85}}, 1e-15));
  EXPECT_FALSE(mean.moves_demonstrations());
  EXPECT_EQ(mean.goals.row(0), mean.goals.row(1));
  const double away = std::hypot(0.1, 0.15);
  EXPECT_TRUE(mean.end_distances(set.demonstrations).isApprox(Vector{{away, away}}, 1e-12));
  const std::vector<Demonstration> kept = mean.normalize(set.demonstrations);
  EXPECT_NEAR(kept[1].position(0, 0) - kept[0].position(0, 0), 0.2 / mean.position_scale, 1e-15);
  const Frame point = find_frame(set, "max_abs", {"", {7.0, -1.0}});
  EXPECT_EQ(point.goal, (Vector{{7.0, -1.0}}));
  EXPECT_EQ(point.end_distances(set.demonstrations)[0], 0.0);
  EXPECT_FALSE(point.moves_demonstrations());
  const Frame each = find_frame(set, "max_abs", {"each"});
  EXPECT_EQ(each.goal, mean.goal);
  EXPECT_TRUE(each.moves_demonstrations());
  EXPECT_EQ(each.goals, (Points{{7, -1}, {7.2, -0.7}}));
  // Equal ends give their own value, bit for bit.
  EXPECT_EQ(find_frame(two_samples(), "max_abs").goal, (Vector{{7, -1}}));
}

TEST(Frame, PositionsGoBackToTheData) {
  const DemonstrationSet set = two_places(0.2, 0.3);
  const Frame frame = find_frame(set, "max_norm");
  const std::vector<Demonstration> normal = frame.normalize(set.demonstrations);
  EXPECT_TRUE(frame.to_data(normal[1].position).isApprox(set.demonstrations[1].position, 1e-15));
  EXPECT_TRUE(frame.to_data(Vector(Vector::Zero(2))) == frame.goal);
}

TEST(Frame, PositionsAreShownToTheMotionsSize) {
  Frame frame;
  frame.unit = "m";
  frame.position_scale = 0.5;
  EXPECT_EQ(frame.position_text(Vector{{0.1 + 0.2, -1e-9}}), "(0.3, 0) m");
  EXPECT_EQ(frame.position_text(Vector{{5412345.678901, 1.0 / 3.0}}), "(5412345.678901, 0.333333) m");
  EXPECT_EQ(frame.position_text(Vector{{1.0 / 3.0}}, Frame::Rounding::up), "(0.333334) m");
  EXPECT_EQ(frame.position_text(Vector{{2.0 / 3.0}}, Frame::Rounding::down), "(0.666666) m");
  frame.unit = "";
  frame.position_scale = 4e8;
  EXPECT_EQ(frame.position_text(Vector{{123456789.0}}), "(123457000)");
}

TEST(Frame, EndsFarFromTheGoalAreRefusedUnlessTheyAreMoved) {
  const DemonstrationSet apart = two_places(1.0, 0.0);  // 0.5 mm of 4 mm from the mean
  const std::string found = "demonstration 0 ends 0.5 mm from the goal (7.5, -1) mm, the mean of all ends";
  expect_error([&] { find_frame(apart, "max_abs"); }, found);
  expect_error([&] { find_frame(apart, "max_abs"); }, "found 12 % of the motion's extent of 4 mm");
  expect_error([&] { find_frame(apart, "max_abs"); }, "data.goal = \"each\"");
  expect_error(
      [&] {
        find_frame(apart, "max_abs", {"", {7.0, -1.0}});
      },
      "demonstration 1 ends 1 mm from the goal (7, -1) mm, which data.goal names");
  EXPECT_NO_THROW(find_frame(apart, "max_abs", {"each"}));
  EXPECT_NO_THROW(find_frame(two_places(0.79, 0.0), "max_abs"));
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
  expect_error([] { find_frame(two_samples(), "max_abs", {"last"}); }, "found \"last\"; expected mean, each");
  expect_error([] { find_frame(two_samples(), "max_abs", {"", {1.0}}); }, "found 1 coordinates; expected 2");
  expect_error([] { find_frame(two_samples(), "max_abs", {"", {1.0, NAN}}); }, "expected finite coordinates");
  expect_error([] { find_frame(two_samples(), "max_abs").normalize({}); },
               "found 0 demonstrations, expected 1");
}

}  // namespace
}  // namespace s2nnds
