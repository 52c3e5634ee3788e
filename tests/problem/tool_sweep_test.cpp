// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/tool_sweep.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/data/orientation.h"

namespace s2nnds {
namespace {

class ToolSweep : public testing::Test {
 protected:
  Eigen::Vector3d draw(double reach) {
    return Eigen::Vector3d::NullaryExpr([&] { return random_.uniform(-reach, reach); });
  }
  // A rotation of `most` rad at most, often of all of it.
  Eigen::Vector4d turned(double most) {
    const double angle = random_.uniform() < 0.5 ? most : random_.uniform(0.0, most);
    return quaternion_of(angle * draw(1.0).normalized());
  }
  // A point of the capsule, often of its surface.
  Eigen::Vector3d point_of(const ToolOptions& tool) {
    const Eigen::Vector3d a(tool.start.data()), b(tool.end.data());
    const double radius = random_.uniform() < 0.5 ? tool.radius : random_.uniform(0.0, tool.radius);
    return a + random_.uniform() * (b - a) + radius * draw(1.0).normalized();
  }

  RandomStream random_{5, "tool-sweep-test"};
};

// Wherever the tool touches the obstacle, the position is in the swept set.
TEST_F(ToolSweep, CoversEveryPoseThatTouches) {
  const RegionOptions ball{.type = "ball", .center = {0.3, -0.2, 0.5}, .radius = 0.1};
  const RegionOptions box{.type = "box", .lower = {0.1, 0.2, 0.3}, .upper = {0.4, 0.3, 0.9}, .inflate = 0.02};
  const RegionOptions turned_box{.type = "oriented_box",
                                 .center = {-0.2, 0.1, 0.0},
                                 .half_sizes = {0.2, 0.1, 0.3},
                                 .rotation = {0.1, 0.5, -0.2, 0.8}};
  const RegionOptions capsule{.type = "capsule", .radius = 0.05, .start = {0, 0, 0}, .end = {0, 0.2, 0.4}};
  const RegionOptions halfspace{.type = "halfspace", .normal = {0.0, 1.0, 2.0}, .offset = -0.3};
  const RegionOptions both{.type = "union", .of = {ball, {.type = "intersection", .of = {box, halfspace}}}};
  const ToolOptions none, rod{.start = {0.02, 0, -0.05}, .end = {0.05, 0.1, 0.4}, .radius = 0.03};
  const ToolOptions needle{.start = {0, 0, 0}, .end = {0, 0, 0.3}};
  EXPECT_TRUE(none.is_none());
  for (const RegionOptions& obstacle : {ball, box, turned_box, capsule, halfspace, both}) {
    const RegionPtr touched = make_region(obstacle, 3);
    for (ToolOptions tool : {rod, needle}) {
      for (const double turn : {0.0, 10.0, 50.0, 85.0}) {
        tool.turn = turn;
        const Eigen::Vector4d goal = quaternion_of(draw(1.7));
        const RegionPtr grown = make_region(swept(obstacle, tool, rotation_matrix(goal)), 3);
        int met = 0;
        for (int i = 0; i < 20000; ++i) {
          const double most = turn == 0.0 ? M_PI : turn * M_PI / 180.0;
          const Eigen::Matrix3d turning = rotation_matrix(product(goal, turned(most)));
          const Eigen::Vector3d at = draw(1.0);
          if (!touched->contains(at)) continue;
          const Eigen::Vector3d position = at - turning * point_of(tool);
          ASSERT_TRUE(grown->contains(position)) << grown->describe() << " at " << position.transpose();
          ++met;
        }
        EXPECT_GT(met, 3);
      }
    }
  }
}

// A tool that hardly turns sweeps little more than itself.
TEST_F(ToolSweep, GrowsByLittleWhereLittleTurns) {
  const RegionOptions ball{.type = "ball", .center = {0, 0, 0}, .radius = 0.1};
  const ToolOptions rod{.start = {0, 0, 0}, .end = {0, 0, 0.3}, .radius = 0.05, .turn = 1.0};
  const RegionPtr grown = make_region(swept(ball, rod, Eigen::Matrix3d::Identity()), 3);
  EXPECT_TRUE(grown->contains(Vector{{0.0, 0.0, -0.44}}));  // 0.1 + 0.3 + 0.05 below
  EXPECT_FALSE(grown->contains(Vector{{0.0, 0.0, -0.50}}));
  EXPECT_FALSE(grown->contains(Vector{{0.0, 0.0, 0.22}}));  // above, where no tool is
  EXPECT_FALSE(grown->contains(Vector{{0.22, 0.0, -0.15}}));
  EXPECT_TRUE(grown->contains(Vector{{0.14, 0.0, -0.15}}));
  // However it turns, it reaches as far everywhere.
  const RegionOptions any =
      swept(ball, {.start = {0, 0, 0}, .end = {0, 0, 0.3}, .radius = 0.05}, Eigen::Matrix3d::Identity());
  EXPECT_EQ(any.type, "ball");
  EXPECT_NEAR(any.inflate, 0.35, 1e-9);
  EXPECT_GE(any.inflate, 0.35);
}

TEST_F(ToolSweep, RefusesWhatHasNoPlace) {
  const ToolOptions rod{.start = {0, 0, 0}, .end = {0, 0, 0.3}, .radius = 0.05, .turn = 30.0};
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  EXPECT_THROW(swept({.type = "expression", .level = "x + y + z"}, rod, identity), Error);
  EXPECT_THROW(swept({.type = "ball", .center = {0, 0, 0}, .radius = 1}, {.start = {0, 0, 0}}, identity),
               Error);
  EXPECT_THROW(swept({.type = "ball", .center = {0, 0, 0}, .radius = 1}, {.start = {0, 0}, .end = {1, 0, 0}},
                     identity),
               Error);
}

}  // namespace
}  // namespace s2nnds
