// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/branch_and_bound.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

// Cuts boxes as often as told until they are narrow, then gives them up.
class Cutter final : public BoxExaminer {
 public:
  Cutter(std::int32_t cuts, double narrow) : cuts_(cuts), narrow_(narrow) {}

  void examine(BoxBatch& batch) override {
    for (Eigen::Index row = batch.first; row < batch.first + batch.count; ++row) {
      const auto at = static_cast<std::size_t>(row);
      batch.cuts[at] = cuts_;
      if ((batch.upper.row(row) - batch.lower.row(row)).maxCoeff() <= narrow_) {
        batch.status[at] = BoxStatus::abandoned;
      }
    }
  }

 private:
  std::int32_t cuts_;
  double narrow_;
};

BranchResult cut(std::int32_t cuts, const BranchLimits& limits, double narrow = 0.25) {
  Points lower(1, 3), upper(1, 3);
  lower << -1.0, 0.0, 2.0;
  upper << 1.0, 1.0, 2.5;
  return branch_and_bound(
      lower, upper, [&] { return std::make_unique<Cutter>(cuts, narrow); }, limits);
}

TEST(BranchAndBound, PartsCoverTheStartHoweverOftenItIsCut) {
  RandomStream random(3, "cuts");
  for (std::int32_t cuts : {1, 2, 3, 5}) {
    const BranchResult result = cut(cuts, {});
    EXPECT_FALSE(result.proved);
    EXPECT_FALSE(result.stopped);
    EXPECT_NEAR(result.open_volume, 1.0, 1e-12);
    for (int k = 0; k < 200; ++k) {
      const Eigen::RowVector3d x(random.uniform(-1.0, 1.0), random.uniform(), random.uniform(2.0, 2.5));
      int holders = 0;
      for (Eigen::Index row = 0; row < result.open_lower.rows(); ++row) {
        holders += (x.array() >= result.open_lower.row(row).array()).all() &&
                   (x.array() <= result.open_upper.row(row).array()).all();
      }
      ASSERT_EQ(holders, 1) << cuts << " cuts";
    }
  }
}

// The first level's one box is cut into as many parts as fill a level, 16.
TEST(BranchAndBound, CutsSaveTheLooksBetween) {
  const BranchResult one = cut(1, {}), three = cut(3, {}), five = cut(5, {});
  EXPECT_EQ(one.open_boxes, 64);  // 2 * 1 * 0.5, cubes with sides of 0.25
  EXPECT_EQ(three.open_boxes, 16 * 8);
  EXPECT_EQ(one.boxes, 1 + 16 + 32 + 64);
  EXPECT_EQ(three.boxes, 1 + 16 + 16 * 8);
  EXPECT_EQ(five.boxes, 1 + 32 + 32 * 32);
}

TEST(BranchAndBound, StopsAfterTheLevelOfTheFirstAbandonedBox) {
  BranchLimits limits;
  limits.max_abandoned = 1;
  limits.kept_boxes = 0;
  // All boxes of a level are alike here, so the level that gives up is the last one in any case.
  EXPECT_EQ(cut(1, limits).boxes, cut(1, {}).boxes);
  limits.max_abandoned = 0;
  const BranchResult none = cut(1, limits);
  EXPECT_EQ(none.boxes, 0);
  EXPECT_TRUE(none.stopped);
  EXPECT_NEAR(none.open_volume, 1.0, 1e-12);
}

// Finds a violation in the lowest corner once the box there is narrow, and never decides anything else.
class CornerRefuter final : public BoxExaminer {
 public:
  void examine(BoxBatch& batch) override {
    for (Eigen::Index row = batch.first; row < batch.first + batch.count; ++row) {
      if (batch.upper.row(row).maxCoeff() > 0.25) continue;
      batch.status[static_cast<std::size_t>(row)] = BoxStatus::refuted;
      batch.violation(row) = 1.0;
    }
  }
};

TEST(BranchAndBound, StopsSoManyBoxesAfterTheFirstRefutedOne) {
  const auto run = [](std::int64_t after) {
    BranchLimits limits;
    limits.max_boxes = 100000;
    limits.max_after_refuted = after;
    return branch_and_bound(
        Points::Zero(1, 2), Points::Ones(1, 2), [] { return std::make_unique<CornerRefuter>(); }, limits);
  };
  // Levels of 1 and 16 boxes; one of the last is refuted, the parts of the others go on.
  EXPECT_EQ(run(0).boxes, 17);
  EXPECT_EQ(run(15).boxes, 17);
  EXPECT_EQ(run(16).boxes, 17 + 30);
  EXPECT_EQ(run(16 + 30).boxes, 17 + 30 + 60);
  const BranchResult result = run(0);
  EXPECT_TRUE(result.stopped);
  EXPECT_FALSE(result.proved);
  EXPECT_EQ(result.witnesses.rows(), 1);
  EXPECT_NEAR(result.open_volume, 1.0, 1e-12);
}

// Limits on boxes alone do not bound a level: its boxes may ask for more parts than there is room for.
TEST(BranchAndBound, StopsBeforeBoxesTakeMoreMemoryThanAllowed) {
  BranchLimits limits;
  limits.max_bytes = 1e6;
  const BranchResult few = cut(1, limits, 1e-9);
  EXPECT_TRUE(few.stopped);
  EXPECT_FALSE(few.proved);
  EXPECT_NEAR(few.open_volume, 1.0, 1e-12);
  EXPECT_GT(few.boxes, 1000);
  EXPECT_LT(few.boxes, 10000);
  EXPECT_EQ(few.expected, 0.0);
  limits.max_bytes = 1e4;
  const BranchResult none = cut(40, limits, 1e-9);
  EXPECT_TRUE(none.stopped);
  EXPECT_EQ(none.boxes, 1);
  EXPECT_EQ(none.open_boxes, 1);
  EXPECT_NEAR(none.open_volume, 1.0, 1e-12);
}

TEST(BranchAndBound, StopsWhereFarTooManyBoxesSeemToBeNeeded) {
  BranchLimits limits;
  limits.max_expected = 1e9;
  const BranchResult found = cut(30, limits, 1e-9);
  EXPECT_EQ(found.boxes, 1 + 64 + 4096);  // six cuts at a time
  EXPECT_TRUE(found.stopped);
  EXPECT_NEAR(found.expected, 4096 * std::exp2(30), 1e6);
  EXPECT_NEAR(found.open_volume, 1.0, 1e-12);
  EXPECT_EQ(cut(1, limits).expected, 0.0);
}

TEST(BranchAndBound, NoCutAtAllIsAnError) { EXPECT_ANY_THROW(cut(0, {})); }

}  // namespace
}  // namespace s2nnds
