// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/topology.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/problem/region.h"

namespace s2nnds {
namespace {

SafetyProblem problem_in(Eigen::Index n) {
  SafetyProblem problem;
  problem.workspace = Box::cube(n, 1.0);
  problem.contained = problem.workspace;
  problem.unsafe = ball(Vector::Constant(n, 0.5), 0.1);
  problem.initial = ball(Vector::Constant(n, -0.5), 0.1);
  return problem;
}

StateFunction scalar(double (*value)(const Eigen::RowVectorXd&)) {
  return [=](const Points& x) -> Points {
    Points y(x.rows(), 1);
    for (Eigen::Index i = 0; i < x.rows(); ++i) y(i, 0) = value(x.row(i));
    return y;
  };
}

const StateFunction kSink = [](const Points& x) -> Points { return -x; };

TEST(Topology, SeesAnIslandAroundTheObstacle) {
  for (const Eigen::Index n : {2, 3}) {
    const SafetyProblem problem = problem_in(n);
    const auto around = [](const Eigen::RowVectorXd& x) { return 0.3 - (x.array() - 0.5).matrix().norm(); };
    const Topology found = find_topology(kSink, scalar(around), problem);
    ASSERT_EQ(found.islands.size(), 1U) << n;
    EXPECT_TRUE(found.islands[0].holds_obstacle);
    const double volume = n == 2 ? M_PI * 0.09 : 4.0 / 3.0 * M_PI * 0.027;
    EXPECT_NEAR(found.islands[0].volume, volume, 0.1 * volume) << n;
    EXPECT_TRUE(found.equilibria.empty());
    EXPECT_FALSE(found.is_possible());
  }
}

TEST(Topology, LetsATailToTheEdgePass) {
  const SafetyProblem problem = problem_in(2);
  const auto tail = [](const Eigen::RowVectorXd& x) {  // the half-strip to the right of the ball
    return x[0] > 0.5 ? 0.2 - std::abs(x[1] - 0.5) : 0.2 - std::hypot(x[0] - 0.5, x[1] - 0.5);
  };
  EXPECT_TRUE(find_topology(kSink, scalar(tail), problem).is_possible());
}

TEST(Topology, SeesAPartThatDoesNotReachTheGoal) {
  // A wall of B > 0 across the workspace, `half` wide on either side of x = 0.4.
  const auto wall = [](double half) {
    return StateFunction([half](const Points& x) -> Points { return half - (x.col(0).array() - 0.4).abs(); });
  };
  const Topology found = find_topology(kSink, wall(0.05), problem_in(2));
  ASSERT_EQ(found.fragments.size(), 1U);
  EXPECT_NEAR(found.fragments[0].volume, 0.55 * 2.0, 0.05);
  EXPECT_GT(found.fragments[0].place[0], 0.4);
  EXPECT_FALSE(found.is_possible());
  EXPECT_TRUE(find_topology(kSink, wall(0.005), problem_in(2)).is_possible());  // less than a cell
  EXPECT_TRUE(find_topology(kSink, wall(0.05), problem_in(3)).is_possible());
}

TEST(Topology, FindsEquilibriaWithTheirIndex) {
  const SafetyProblem problem = problem_in(2);
  const auto inside = [](const Eigen::RowVectorXd&) { return -1.0; };
  // x' = -x (x - 0.52) (x - 0.7), y' = -y: a saddle at 0.52, a sink at 0.7 and at the goal.
  const StateFunction f = [](const Points& x) -> Points {
    Points v(x.rows(), 2);
    v.col(0) = -x.col(0).array() * (x.col(0).array() - 0.52) * (x.col(0).array() - 0.7);
    v.col(1) = -x.col(1);
    return v;
  };
  const Topology found = find_topology(f, scalar(inside), problem);
  ASSERT_EQ(found.equilibria.size(), 2U);
  for (const Equilibrium& rest : found.equilibria) {
    EXPECT_NEAR(rest.place[1], 0.0, 1e-6);
    EXPECT_EQ(rest.index, rest.place[0] < 0.6 ? -1 : 1);
    EXPECT_FALSE(rest.in_obstacle);
  }
  EXPECT_TRUE(find_topology(kSink, scalar(inside), problem).is_possible());
}

TEST(Topology, SaysNothingBeyondThreeDimensions) {
  const auto island = [](const Eigen::RowVectorXd& x) { return 0.3 - x.norm(); };
  EXPECT_TRUE(find_topology(kSink, scalar(island), problem_in(4)).is_possible());
}

}  // namespace
}  // namespace s2nnds
