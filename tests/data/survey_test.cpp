// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/survey.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "s2nnds/data/handwriting.h"
#include "s2nnds/data/readers.h"

namespace s2nnds {
namespace {

// A motion at times 0 to 2 s, by its position at a share 0 to 1 of the way.
Demonstration motion(const std::function<Vector(double)>& position, Eigen::Index samples = 101) {
  Demonstration d{Vector::LinSpaced(samples, 0, 2), Points(samples, position(0).size()), {}};
  for (Eigen::Index i = 0; i < samples; ++i)
    d.position.row(i) = position(static_cast<double>(i) / static_cast<double>(samples - 1)).transpose();
  d.velocity = differentiate(d.time, d.position);
  return d;
}

Vector at(double x, double y) { return Eigen::Vector2d(x, y); }

TEST(Survey, MeasuresStraightMotions) {
  DemonstrationSet set{"two", "m", {}};
  for (const double y : {-0.1, 0.1}) {
    set.demonstrations.push_back(motion([y](double s) { return at(4 * s, y * (1 - s)); }));
  }
  const Survey s = survey(set);
  EXPECT_DOUBLE_EQ(s.duration[0], 2);
  EXPECT_NEAR(s.usual_speed[1], std::hypot(2, 0.05), 1e-9);
  EXPECT_NEAR(s.peak_speed[1], std::hypot(2, 0.05), 1e-9);
  EXPECT_DOUBLE_EQ(s.extent, 4);
  EXPECT_DOUBLE_EQ(s.start_spread, 0.1);
  EXPECT_DOUBLE_EQ(s.end_spread, 0);
  EXPECT_FALSE(s.is_closed(0));
  EXPECT_TRUE(s.crossings.empty());
  EXPECT_TRUE(s.pauses.empty());
}

TEST(Survey, FindsClosedMotionsAndLoops) {
  DemonstrationSet circle{
      "circle", "m", {motion([](double s) { return at(std::cos(2 * M_PI * s), std::sin(2 * M_PI * s)); })}};
  EXPECT_TRUE(survey(circle).is_closed(0));
  // A line with a loop in its middle, which crosses itself at a right angle.
  DemonstrationSet loop{"loop",
                        "m",
                        {motion(
                            [](double s) {
                              const double t = 3 * s - 1.5;
                              return at(t * t * t - t + 2 * s, 1 - t * t);
                            },
                            301)}};
  const Demonstration& d = loop.demonstrations[0];
  const Survey s = survey(loop);
  // x(t) = t^3 - t / 3 + 1: equal heights at t and -t meet where t^2 = 1 / 3.
  ASSERT_EQ(s.crossings.size(), 1U);
  EXPECT_EQ(s.crossings[0].first, 0U);
  EXPECT_EQ(s.crossings[0].second, 0U);
  EXPECT_NEAR(s.crossings[0].place[0], 1, 0.05);
  EXPECT_NEAR(s.crossings[0].place[1], 2.0 / 3.0, 0.05);
  EXPECT_GT(s.crossings[0].angle, M_PI / 3);
  EXPECT_NEAR(s.crossings[0].second_time - s.crossings[0].first_time, 2 * 2 * std::sqrt(1.0 / 3.0) / 3, 0.05);
  EXPECT_GT(d.samples(), 0);
}

TEST(Survey, FindsOpposingDemonstrationsAndNoNeighbours) {
  const auto left = [](double s) { return at(-std::cos(M_PI * s), 0.3 * (1 - s)); };
  DemonstrationSet set{"two", "m", {motion(left), motion([&](double s) { return left(1 - s); })}};
  const Survey opposing = survey(set);
  ASSERT_EQ(opposing.crossings.size(), 1U);
  EXPECT_EQ(opposing.crossings[0].first, 0U);
  EXPECT_EQ(opposing.crossings[0].second, 1U);
  EXPECT_GT(opposing.crossings[0].angle, 3);
  for (const std::string& name : handwriting_motions()) {
    const Survey written = survey(handwriting(name));
    EXPECT_TRUE(written.crossings.empty()) << name;
  }
}

// Two that start together: where they part, no law follows both; where one of them trembles first, it does not matter.
TEST(Survey, TellsPartingFromTrembling) {
  const auto bent = [](double side) {
    return [side](double s) { return at(std::cos(M_PI * s), side * std::sin(M_PI * s)); };
  };
  DemonstrationSet parting{"parting", "m", {motion(bent(1)), motion(bent(-1))}};
  ASSERT_EQ(survey(parting).crossings.size(), 1U);
  EXPECT_GT(survey(parting).crossings[0].angle, 3);
  const auto line = [](double s) { return at(1 - s, 0.0); };
  const auto hook = [&](double back) {
    return [back](double s) { return at(1 - s + (s < back ? 2 * s : 2 * back), 0.001 * s); };
  };
  for (const auto& [back, count] : {std::pair(0.02, 0U), std::pair(0.2, 1U)}) {
    DemonstrationSet set{"hook", "m", {motion(line), motion(hook(back))}};
    set.demonstrations[0].position.col(0).array() += back;  // starts within the other one's hook
    EXPECT_EQ(survey(set).crossings.size(), count) << back;
  }
}

TEST(Survey, FindsStopsOnTheWay) {
  DemonstrationSet set{"stop", "m", {motion([](double s) {
                         const double way = s < 0.4 ? s / 0.8 : s < 0.6 ? 0.5 : (s - 0.2) / 0.8;
                         return at(way, 0.1 * way);
                       })}};
  const Survey s = survey(set);
  ASSERT_EQ(s.pauses.size(), 1U);
  EXPECT_NEAR(s.pauses[0].start, 0.8, 0.05);
  EXPECT_NEAR(s.pauses[0].duration, 0.4, 0.05);
  EXPECT_NEAR(s.pauses[0].place[0], 0.5, 0.01);
}

TEST(Survey, PlacesAlongAPathAreEven) {
  Points corner(3, 2);
  corner << 0, 0, 1, 0, 1, 3;
  const Points even = along_path(corner, 5);
  EXPECT_TRUE(even.row(1).isApprox(Eigen::RowVector2d(1, 0)));
  EXPECT_TRUE(even.row(3).isApprox(Eigen::RowVector2d(1, 2)));
  EXPECT_TRUE(even.row(4).isApprox(Eigen::RowVector2d(1, 3)));
}

}  // namespace
}  // namespace s2nnds
