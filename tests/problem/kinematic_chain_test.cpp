// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/kinematic_chain.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

using Rows = std::vector<std::vector<double>>;

const Rows kFranka = {{0, 0, 0.333, 0},         {0, -M_PI / 2, 0, 0},           {0, M_PI / 2, 0.316, 0},
                      {0.0825, M_PI / 2, 0, 0}, {-0.0825, -M_PI / 2, 0.384, 0}, {0, M_PI / 2, 0, 0},
                      {0.088, M_PI / 2, 0, 0}};
// Universal Robots' published table of the UR5, standard.
const Rows kUr5 = {{0, M_PI / 2, 0.089159, 0}, {-0.425, 0, 0, 0},          {-0.39225, 0, 0, 0},
                   {0, M_PI / 2, 0.10915, 0},  {0, -M_PI / 2, 0.09465, 0}, {0, 0, 0.0823, 0}};

KinematicChain chain_of(const Rows& rows, DhConvention convention) {
  return {rows, convention, Vector::Zero(3), no_rotation(3)};
}

Eigen::Vector3d place(const KinematicChain& chain, std::size_t frame, const Eigen::Vector3d& at,
                      const std::vector<double>& angles) {
  const FramePose<double> pose = chain.frames(angles)[frame];
  const std::array<double, 3> turned = pose.turned(at);
  return {pose.origin[0] + turned[0], pose.origin[1] + turned[1], pose.origin[2] + turned[2]};
}

// By matrices as the textbooks write them.
Eigen::Vector3d by_matrices(const Rows& rows, DhConvention convention, std::size_t frame,
                            const Eigen::Vector3d& at, const std::vector<double>& angles) {
  Eigen::Vector4d x(at[0], at[1], at[2], 1.0);
  for (std::size_t i = frame; i-- > 0;) {
    const double a = rows[i][0], d = rows[i][2], t = angles[i] + rows[i][3];
    const double ca = std::cos(rows[i][1]), sa = std::sin(rows[i][1]), ct = std::cos(t), st = std::sin(t);
    Eigen::Matrix4d m;
    if (convention == DhConvention::modified) {
      m << ct, -st, 0, a, st * ca, ct * ca, -sa, -d * sa, st * sa, ct * sa, ca, d * ca, 0, 0, 0, 1;
    } else {
      m << ct, -st * ca, st * sa, a * ct, st, ct * ca, -ct * sa, a * st, 0, sa, ca, d, 0, 0, 0, 1;
    }
    x = m * x;
  }
  return x.head(3);
}

TEST(KinematicChain, KnowsPublishedPoses) {
  // The Franka arm's ready pose, as its driver reports the flange: 0.1034 above the hand's O_T_EE.
  const KinematicChain franka = chain_of(kFranka, DhConvention::modified);
  const std::vector<double> ready = {0, -M_PI / 4, 0, -3 * M_PI / 4, 0, M_PI / 2, M_PI / 4};
  const Eigen::Vector3d flange = place(franka, 7, {0, 0, 0.107}, ready);
  EXPECT_LT((flange - Eigen::Vector3d(0.3069, 0.0, 0.5903)).norm(), 2e-4) << flange.transpose();
  // The UR5 stretched out along -x.
  const KinematicChain ur5 = chain_of(kUr5, DhConvention::standard);
  const Eigen::Vector3d wrist = place(ur5, 6, {0, 0, 0}, {0, 0, 0, 0, 0, 0});
  EXPECT_LT((wrist - Eigen::Vector3d(-0.81725, -0.19145, -0.005491)).norm(), 1e-9) << wrist.transpose();
}

TEST(KinematicChain, IsTheProductOfItsMatrices) {
  RandomStream random(3, "kinematic-chain-test");
  for (const auto& [rows, convention] :
       {std::pair{kFranka, DhConvention::modified}, std::pair{kUr5, DhConvention::standard},
        std::pair{kFranka, DhConvention::standard}}) {
    Rows offset = rows;
    for (std::vector<double>& row : offset) row[3] = random.uniform(-1.0, 1.0);
    const KinematicChain chain = chain_of(offset, convention);
    for (int k = 0; k < 200; ++k) {
      std::vector<double> angles;
      for (std::size_t i = 0; i < rows.size(); ++i) angles.push_back(random.uniform(-3.0, 3.0));
      const std::size_t frame =
          static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(rows.size()) + 0.99));
      const Eigen::Vector3d at(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      const Eigen::Vector3d found = place(chain, frame, at, angles);
      EXPECT_LT((found - by_matrices(offset, convention, frame, at, angles)).norm(), 1e-13);
      if (frame == 0) continue;
      // A link's ends are the origins.
      const FrameSegment link = chain.link(static_cast<Eigen::Index>(frame));
      const auto of = static_cast<std::size_t>(link.frame);
      EXPECT_LT((place(chain, of, link.start, angles) - place(chain, frame - 1, {0, 0, 0}, angles)).norm(),
                1e-13);
      EXPECT_LT((place(chain, of, link.end, angles) - place(chain, frame, {0, 0, 0}, angles)).norm(), 1e-13);
    }
  }
}

// A joint that turns by a moves a point by 2 sin(a / 2) times its distance from the axis.
TEST(KinematicChain, ReachesBoundWhatAJointMoves) {
  RandomStream random(4, "kinematic-chain-test");
  for (const auto& [rows, convention] :
       {std::pair{kFranka, DhConvention::modified}, std::pair{kUr5, DhConvention::standard}}) {
    const KinematicChain chain = chain_of(rows, convention);
    for (int k = 0; k < 2000; ++k) {
      std::vector<double> angles;
      for (std::size_t i = 0; i < rows.size(); ++i) angles.push_back(random.uniform(-3.0, 3.0));
      const std::size_t frame =
          1 + static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(rows.size()) - 0.01));
      const Eigen::Vector3d at(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2),
                               random.uniform(-0.2, 0.2));
      const std::vector<double> reach = chain.reaches(static_cast<Eigen::Index>(frame), at);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        std::vector<double> turned = angles;
        turned[i] += 0.5;
        const double moved = (place(chain, frame, at, turned) - place(chain, frame, at, angles)).norm();
        EXPECT_LE(moved, 2 * std::sin(0.25) * reach[i] + 1e-12) << "joint " << i << " frame " << frame;
        if (i >= frame) {
          EXPECT_EQ(reach[i], 0.0);
        }
      }
    }
    // An origin on the first axis never moves.
    for (const double reach : chain.reaches(1, {0, 0, 0})) EXPECT_EQ(reach, 0.0);
  }
}

TEST(KinematicChain, IntervalsHoldTheFrames) {
  RandomStream random(5, "kinematic-chain-test");
  const KinematicChain chain(kFranka, DhConvention::modified, Vector{{0.3, -0.2, 0.1}},
                             rotation_in_space({0.1, 0.5, -0.2, 0.8}));
  for (int k = 0; k < 300; ++k) {
    const double width = std::pow(10.0, random.uniform(-14.0, 0.5));
    std::vector<double> angles;
    std::vector<Interval> boxes;
    for (std::size_t i = 0; i < 7; ++i) {
      const double low = random.uniform(-3.0, 3.0);
      angles.push_back(low + width * random.uniform());
      boxes.emplace_back(low, low + width);
    }
    const auto exact = chain.frames(boxes);
    const auto rounded = chain.frames(angles);
    for (std::size_t f = 0; f < exact.size(); ++f) {
      for (std::size_t i = 0; i < 9; ++i) {
        EXPECT_LE(exact[f].axes[i].lower, rounded[f].axes[i] + 1e-14);
        EXPECT_GE(exact[f].axes[i].upper, rounded[f].axes[i] - 1e-14);
        if (i > 2) continue;
        EXPECT_LE(exact[f].origin[i].lower, rounded[f].origin[i] + 1e-14);
        EXPECT_GE(exact[f].origin[i].upper, rounded[f].origin[i] - 1e-14);
      }
    }
  }
}

}  // namespace
}  // namespace s2nnds
