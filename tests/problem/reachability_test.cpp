// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/reachability.h"

#include <gtest/gtest.h>

namespace s2nnds {
namespace {

SafetyProblem problem(RegionPtr unsafe, RegionPtr initial) {
  const Eigen::Index n = unsafe->dimension();
  SafetyProblem made;
  made.workspace = made.contained = Box::cube(n, 1);
  made.initial = std::move(initial);
  made.unsafe = std::move(unsafe);
  return made;
}

RegionPtr start_box(Eigen::Index n) {
  Vector lower = Vector::Constant(n, -0.1), upper = Vector::Constant(n, 0.1);
  lower[0] = -0.9;
  upper[0] = -0.7;
  return box_region({lower, upper});
}

TEST(Reachability, AWallWithADoorCutsNothingOff) {
  for (const char* wall : {"abs(x + 0.4) - 0.05", "max(abs(x + 0.4) - 0.05, y - 0.7)"}) {
    const bool closed = std::string(wall).find("max") == std::string::npos;
    for (const Eigen::Index n : {2, 3}) {
      const auto found = find_reachability(problem(expression(wall, n), start_box(n)), Points(0, n));
      ASSERT_TRUE(found);
      EXPECT_EQ(found->cut_off, closed ? 1.0 : 0.0) << wall << n;
      EXPECT_EQ(found->goal_is_walled_in, closed);
      EXPECT_EQ(found->place.size(), closed ? n : 0);
    }
  }
}

TEST(Reachability, FindsThePartThatIsCutOff) {
  // A closed ring around the upper half of the starts.
  const RegionPtr ring = expression("abs(sqrt((x + 0.8)^2 + (y - 0.5)^2) - 0.3) - 0.03", 2);
  const RegionPtr starts = box_region({Eigen::Vector2d(-0.85, -0.5), Eigen::Vector2d(-0.75, 0.5)});
  const auto found = find_reachability(problem(ring, starts), Points(0, 2));
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->goal_is_walled_in);
  EXPECT_NEAR(found->cut_off, 0.27 / 0.94, 0.03);
  EXPECT_LT((found->place - Eigen::Vector2d(-0.8, 0.5)).norm(), 0.3);
  // A demonstration's start counts as well, wherever the initial set is.
  Points start(1, 2);
  start << -0.8, 0.5;
  const RegionPtr elsewhere = box_region({Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(0.6, 0.6)});
  EXPECT_GT(find_reachability(problem(ring, elsewhere), start)->cut_off, 0);
}

TEST(Reachability, SaysNothingInManyDimensions) {
  EXPECT_FALSE(find_reachability(problem(empty_region(4), start_box(4)), Points(0, 4)));
}

}  // namespace
}  // namespace s2nnds
