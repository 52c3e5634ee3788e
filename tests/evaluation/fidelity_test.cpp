// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/fidelity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {
namespace {

SafetyProblem problem_with(RegionPtr unsafe) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 2.0);
  problem.contained = problem.workspace;
  problem.unsafe = std::move(unsafe);
  problem.initial = ball(Vector::Constant(2, -1.0), 0.1);
  return problem;
}

RegionPtr nothing() { return ball(Vector::Constant(2, 1.9), 1e-3); }

// From (1, bow(1)) to the origin along y = bow(x).
template <typename Bow>
Demonstration shown(Bow bow, double duration = 3.0) {
  constexpr Eigen::Index kSamples = 101;
  Demonstration d;
  d.time = Vector::LinSpaced(kSamples, 0.0, duration);
  d.position.resize(kSamples, 2);
  d.velocity = Points::Zero(kSamples, 2);
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    const double x = 1.0 - static_cast<double>(i) / (kSamples - 1);
    d.position.row(i) << x, bow(x);
  }
  return d;
}

const StateFunction kStraight = [](const Points& x) -> Points { return -x; };

TEST(Fidelity, IsZeroOnThePathWhateverTheSpeed) {
  for (const double duration : {0.1, 3.0, 100.0}) {
    const auto found = deviations(kStraight, problem_with(nothing()),
                                  {shown([](double) { return 0.0; }, duration)}, 0.1, 0.0);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_LT(found[0].largest, 0.025);  // the motion ends 0.02 from the goal
    EXPECT_TRUE(found[0].follows());
  }
}

TEST(Fidelity, MeasuresABow) {
  const auto bow = [](double x) { return 2.0 * x * (1.0 - x); };  // 0.5 high
  const auto found = deviations(kStraight, problem_with(nothing()), {shown(bow)}, 0.1, 0.0);
  EXPECT_NEAR(found[0].largest, 0.5, 0.03);
  EXPECT_GT(found[0].mean, 0.25);
  EXPECT_LT(found[0].mean, 0.4);
  EXPECT_FALSE(found[0].follows());
  EXPECT_NEAR(worst_share(found), found[0].mean / 0.1, 1e-12);
}

TEST(Fidelity, AMotionThatStandsStillDoesNotFollow) {
  const StateFunction still = [](const Points& x) -> Points { return 0.0 * x; };
  const auto found =
      deviations(still, problem_with(nothing()), {shown([](double) { return 0.0; })}, 0.1, 0.0);
  EXPECT_NEAR(found[0].largest, 1.0, 1e-6);
  EXPECT_FALSE(found[0].follows());
}

TEST(Fidelity, DoesNotCountPlacesInTheObstacle) {
  const auto bow = [](double x) { return x > 0.4 && x < 0.6 ? 0.3 : 0.0; };
  const Vector place = (Vector(2) << 0.5, 0.3).finished();
  EXPECT_FALSE(deviations(kStraight, problem_with(nothing()), {shown(bow)}, 0.05, 0.0)[0].follows());
  EXPECT_TRUE(deviations(kStraight, problem_with(ball(place, 0.2)), {shown(bow)}, 0.05, 0.1)[0].follows());
}

TEST(Fidelity, AllowsALittleMoreWhereDemonstrationsDiffer) {
  const auto bow = [](double height) { return shown([=](double x) { return height * x * (1.0 - x); }); };
  const auto near = deviations(kStraight, problem_with(nothing()), {bow(0.38), bow(-0.38)}, 0.1, 0.0);
  EXPECT_GT(near[0].limit, 0.1);
  EXPECT_LT(near[0].limit, 0.15);
  EXPECT_TRUE(near[0].follows());
  // Two ways that no one motion takes: their distance excuses nothing.
  const auto apart = deviations(kStraight, problem_with(nothing()), {bow(1.6), bow(-1.6)}, 0.1, 0.0);
  EXPECT_DOUBLE_EQ(apart[0].limit, 0.1 * 1.5);
  EXPECT_FALSE(apart[0].follows());
  EXPECT_FALSE(apart[1].follows());
}

TEST(Fidelity, MeasuresStartsByTheNearestDemonstration) {
  const auto straight = shown([](double) { return 0.0; });
  const auto bow = shown([](double x) { return 2.0 * x * (1.0 - x); });
  Points starts(2, 2);
  starts << 1.0, 0.0, 0.0, 1.0;
  const auto found = start_deviations(kStraight, problem_with(nothing()), {bow, straight}, starts, 0.1, 0.0);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_LT(found[0].largest, 0.025);  // along the second
  EXPECT_TRUE(found[0].follows());
  EXPECT_GT(found[1].limit, 0.4);  // far from both starts
  EXPECT_NEAR(found[1].largest, std::sqrt(2.0), 0.7);
}

TEST(Fidelity, AllowsForAStartThatLiesApart) {
  const auto straight = shown([](double) { return 0.0; });
  Points starts(2, 2);
  starts << 1.0, 0.0, 1.0, 0.3;
  const auto found = start_deviations(kStraight, problem_with(nothing()), {straight}, starts, 0.1, 0.0);
  EXPECT_DOUBLE_EQ(found[0].limit, 0.1);
  EXPECT_NEAR(found[1].limit, 0.2, 1e-12);
  EXPECT_NEAR(found[1].mean, 0.15, 0.03);  // its distance falls evenly
  EXPECT_TRUE(found[1].follows());
}

TEST(Fidelity, DoesNotJudgeAStartWhoseWayIsBlocked) {
  const auto bow = [](double x) { return 2.0 * x * (1.0 - x); };
  const Points start = (Points(1, 2) << 1.0, 0.2).finished();
  const auto judged = start_deviations(kStraight, problem_with(nothing()), {shown(bow)}, start, 0.1, 0.0);
  EXPECT_FALSE(judged[0].follows());
  const Vector on_the_way = (Vector(2) << 0.9, 0.18 + 0.2 * 0.81).finished();
  const auto blocked =
      start_deviations(kStraight, problem_with(ball(on_the_way, 0.05)), {shown(bow)}, start, 0.1, 0.0);
  EXPECT_TRUE(blocked[0].follows());
}

TEST(Fidelity, CorrectsTheMotionsThatStrayBackToTheirWay) {
  const auto straight = shown([](double) { return 0.0; });
  const Points none(0, 2);
  EXPECT_EQ(corrections_of(kStraight, problem_with(nothing()), {straight}, none, 0.1, 0.0).position.rows(),
            0);
  // A field that drifts downwards first.
  const StateFunction drifts = [](const Points& x) -> Points {
    Points v = -x;
    v.col(1).array() -= 2.0 * x.col(0).array();
    return v;
  };
  const VelocityTargets found = corrections_of(drifts, problem_with(nothing()), {straight}, none, 0.1, 0.0);
  ASSERT_GT(found.position.rows(), 10);
  ASSERT_EQ(found.velocity.rows(), found.position.rows());
  std::int64_t away = 0;
  for (Eigen::Index i = 0; i < found.position.rows(); ++i) {
    if (found.position(i, 1) > -0.05) continue;  // on the way itself
    ++away;
    EXPECT_GT(found.velocity(i, 1), 0.0);
  }
  EXPECT_GT(away, 5);
  EXPECT_THROW(corrections_of(drifts, problem_with(nothing()), {}, none, 0.1, 0.0), Error);
}

// Of two demonstrations, from both sides, the one from the right is not followed.
TEST(Fidelity, ShowsTheDemonstrationsBesideOneThatStraysUnlessTheyPassThroughTheObstacle) {
  const auto right = shown([](double) { return 0.0; });
  auto left = shown([](double x) { return 0.32 * x * (1.0 - x); });  // 0.08 high
  left.position.col(0) *= -1.0;
  const StateFunction drifts = [](const Points& x) -> Points {
    Points v = -x;
    v.col(1).array() -= 2.0 * x.col(0).array().max(0.0);
    return v;
  };
  const auto on_the_left = [&](const RegionPtr& unsafe) {
    const Points none(0, 2);
    const VelocityTargets found = corrections_of(drifts, problem_with(unsafe), {right, left}, none, 0.1, 0.0);
    EXPECT_GT(found.position.rows(), 100);
    return static_cast<double>((found.position.col(0).array() < -0.05).count()) /
           static_cast<double>(found.position.rows());
  };
  EXPECT_NEAR(on_the_left(nothing()), 0.25, 0.1);
  EXPECT_EQ(on_the_left(ball((Vector(2) << -0.5, 0.1).finished(), 0.05)), 0.0);
}

TEST(Fidelity, DoesNotCorrectMotionsIntoAnObstacleThroughWhichTheyAreLed) {
  const Vector on_the_way = (Vector(2) << 0.5, 0.0).finished();
  const auto problem = problem_with(ball(on_the_way, 0.1));
  const Points none(0, 2);
  EXPECT_EQ(
      corrections_of(kStraight, problem, {shown([](double) { return 0.0; })}, none, 0.1, 0.0).position.rows(),
      0);
  const auto bow = [](double x) { return 2.0 * x * (1.0 - x); };  // around it
  EXPECT_GT(corrections_of(kStraight, problem, {shown(bow)}, none, 0.1, 0.0).position.rows(), 10);
}

}  // namespace
}  // namespace s2nnds
