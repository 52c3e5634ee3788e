// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/phase.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "s2nnds/core/check.h"
#include "s2nnds/data/handwriting.h"
#include "s2nnds/data/readers.h"

namespace s2nnds {
namespace {

// A motion over 2 s, by its position at a share 0 to 1 of the time.
Demonstration motion(const std::function<Eigen::Vector2d(double)>& position, Eigen::Index samples = 401) {
  Demonstration d{Vector::LinSpaced(samples, 0, 2), Points(samples, 2), {}};
  for (Eigen::Index i = 0; i < samples; ++i)
    d.position.row(i) = position(static_cast<double>(i) / static_cast<double>(samples - 1)).transpose();
  d.velocity = differentiate(d.time, d.position);
  return d;
}

double minimum_jerk(double u) { return u * u * u * (10 + u * (6 * u - 15)); }

Eigen::Vector2d circle(double share) {
  return {5 + 0.2 * std::cos(2 * M_PI * share), 0.2 * std::sin(2 * M_PI * share)};
}
Eigen::Vector2d line(double share) { return {share, 0.1 * share * share}; }
// A line with a loop of this size in its middle.
Eigen::Vector2d looped(double share, double size) {
  const double turn = 2 * M_PI * std::clamp(3 * share - 1, 0.0, 1.0);
  return {share < 1.0 / 3   ? 1.5 * share
          : share > 2.0 / 3 ? 1.5 * share - 0.5
                            : 0.5 + size * std::sin(turn),
          size * (1 - std::cos(turn))};
}

DemonstrationSet set_of(std::vector<Demonstration> demonstrations) {
  return {"test", "m", std::move(demonstrations)};
}
PhaseChoice chosen(const DemonstrationSet& set, const std::string& state = "auto") {
  return choose_phase(state, set, survey(set));
}

TEST(Phase, OfACircleAtConstantSpeedFallsLinearly) {
  DemonstrationSet set = set_of({motion(circle)});
  const Frame places = find_frame(set, "max_abs");
  const Frame frame = add_phase(set, places);
  const Demonstration& d = set.demonstrations[0];
  ASSERT_EQ(d.dimension(), 3);
  const double length = 0.4 * M_PI;
  EXPECT_NEAR(frame.phase_start, length, 1e-4);
  EXPECT_EQ(frame.position_scale, places.position_scale);
  for (Eigen::Index i = 0; i < d.samples(); ++i) {
    EXPECT_NEAR(d.position(i, 2), length * (1 - d.time[i] / 2), 1e-4);
    EXPECT_NEAR(d.velocity(i, 2), -length / 2, 3e-4);
  }
  EXPECT_EQ(d.position(d.samples() - 1, 2), 0.0);
  EXPECT_TRUE(frame.has_phase());
  EXPECT_EQ(frame.places(), 2);
  EXPECT_EQ(frame.goal.size(), 3);
  EXPECT_EQ(frame.goal[2], 0.0);
  EXPECT_EQ(frame.goals.cols(), 3);
  EXPECT_NO_THROW(frame.check(1, 3, "test"));
  const Demonstration normalised = frame.normalize(set.demonstrations)[0];
  EXPECT_NEAR(normalised.position(0, 2), frame.phase_start / 0.4, 1e-6);  // the goal is at (5.2, 0)
  EXPECT_LE(normalised.velocity.cwiseAbs().maxCoeff(), 1.0 + 1e-12);
  const Frame again = frame.of_places();
  EXPECT_EQ(again.goal, places.goal);
  EXPECT_EQ(again.goals, places.goals);
  EXPECT_FALSE(again.has_phase());
  EXPECT_EQ(frame.position_text(Vector{{5.2, 0.0, 0.4}}), "(5.2, 0) m, s = 0.4 m");
}

// Of demonstrations of different lengths it starts at one number.
TEST(Phase, StartsAtTheMeanLength) {
  const auto large = [](double share) {
    return Eigen::Vector2d(1.5 * circle(share) - Eigen::Vector2d(2.6, 0));
  };
  DemonstrationSet set = set_of({motion(circle), motion(large)});
  const Frame frame = add_phase(set, find_frame(set, "max_abs"));
  EXPECT_NEAR(frame.phase_start, 0.5 * M_PI, 1e-4);
  for (const Demonstration& d : set.demonstrations) EXPECT_EQ(d.position(0, 2), frame.phase_start);
}

// Its rate is its derivative, and both vanish with the speed at the end.
TEST(Phase, MovesWithTheSpeed) {
  DemonstrationSet set =
      set_of({motion([](double share) { return looped(minimum_jerk(share), 0.1); }, 2001)});
  const Frame frame = add_phase(set, find_frame(set, "max_norm"));
  const Demonstration& d = set.demonstrations[0];
  const Points rate = differentiate(d.time, d.position.rightCols(1));
  EXPECT_LE((rate - d.velocity.rightCols(1)).cwiseAbs().maxCoeff(), 3e-2 * rate.cwiseAbs().maxCoeff());
  EXPECT_NEAR(d.velocity(d.samples() - 1, 2), 0.0, 1e-3 * rate.cwiseAbs().maxCoeff());
  const Vector lengths = d.velocity.leftCols(2).rowwise().norm();
  EXPECT_LE(
      (lengths / lengths.maxCoeff() - d.velocity.col(2) / d.velocity.col(2).minCoeff()).cwiseAbs().maxCoeff(),
      1e-12);
  // The scale counts s' too.
  EXPECT_NEAR(frame.normalize(set.demonstrations)[0].velocity.rowwise().norm().maxCoeff(), 1.0, 1e-12);
}

TEST(Phase, IsChosenForMotionsThatComeBackAlone) {
  EXPECT_NE(chosen(set_of({motion(circle)})).reason.find("1 of 1 end where they start or were before"),
            std::string::npos);
  const auto loop = [](double share) { return looped(share, 0.15); };
  EXPECT_NE(chosen(set_of({motion(loop), motion(loop), motion(line)})).reason.find("2 of 3 cross themselves"),
            std::string::npos);
  EXPECT_FALSE(chosen(set_of({motion(loop), motion(line), motion(line)})).used);
  EXPECT_FALSE(chosen(set_of({motion(line)})).used);
  // An eight that ends in its middle, from a start a tenth of its width away.
  EXPECT_NE(chosen(set_of({motion([](double share) {
              return Eigen::Vector2d(0.5 * std::sin(2 * M_PI * share),
                                     0.3 * std::sin(4 * M_PI * share) - 0.1 * (1 - share));
            })}))
                .reason.find("1 of 1 end where they start or were before"),
            std::string::npos);
  // An overshoot.
  EXPECT_FALSE(chosen(set_of({motion([](double share) {
                 return Eigen::Vector2d(share < 0.8 ? 1.5 * share : 2.0 - share, 0.1 * share);
               })}))
                   .used);
  // What is small beside the motion can be left out.
  EXPECT_FALSE(chosen(set_of({motion([](double share) { return looped(share, 0.03); }, 4001)})).used);
  // Demonstrations that cross each other alone.
  EXPECT_FALSE(chosen(set_of({motion(line), motion([](double share) { return line(1 - share); })})).used);
  for (const std::string& name : handwriting_motions()) EXPECT_FALSE(chosen(handwriting(name)).used) << name;
  for (const char* state : {"position", "pose", "joints"})
    EXPECT_FALSE(chosen(set_of({motion(circle)}), state).used) << state;
  EXPECT_TRUE(chosen(set_of({motion(line)}), "phase").used);
  EXPECT_NE(chosen(handwriting("Helix"), "phase").reason.find("4 dimensions, in which a proof may not end"),
            std::string::npos);
}

TEST(Phase, ChoiceIsReported) {
  DemonstrationSet set = set_of({motion(circle)});
  EXPECT_TRUE(find_state(set, "auto", "max_abs", {"mean"}).has_phase());
  ASSERT_EQ(set.report.size(), 1U);
  EXPECT_NE(set.report[0].find("auto chose phase"), std::string::npos);
  DemonstrationSet other = handwriting("Sine");
  const Frame frame = find_state(other, "auto", "max_abs", {"mean"});
  EXPECT_FALSE(frame.has_phase());
  EXPECT_EQ(frame.goal, find_frame(other, "max_abs").goal);
  EXPECT_EQ(other.dimension(), 2);
  EXPECT_TRUE(other.report.empty());
}

TEST(Phase, NeedsVelocities) {
  DemonstrationSet set = set_of({motion(circle), motion(circle)});
  const Frame frame = find_frame(set, "max_abs");
  set.demonstrations[1].velocity.setZero();
  EXPECT_THROW(add_phase(set, frame), Error);
}

}  // namespace
}  // namespace s2nnds
