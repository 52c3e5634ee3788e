// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/cleaning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "s2nnds/data/local_polynomial.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

constexpr double kPause = 1.2;  // s of rest at the end of recording()

// Half a circle of radius 1 in 3 s at even speed, 100 samples a second.
Recording recording() {
  Recording r{"arm.csv", "t", 0, Vector::LinSpaced(301, 0, 3), Points(301, 2), {}};
  const Vector angle = M_PI * r.time / 3;
  r.position.col(0) = angle.array().cos();
  r.position.col(1) = angle.array().sin();
  for (std::int64_t i = 0; i < 301; ++i) r.lines.push_back(i + 2);
  return r;
}

CleanDemonstration cleaned(const Recording& r, const CleaningOptions& options = {}) {
  return clean(r, options, 1, "m");
}

// What is reported besides the noise, which always is.
std::vector<std::string> steps(const Recording& r, const CleaningOptions& options = {}) {
  std::vector<std::string> all = cleaned(r, options).steps;
  std::erase_if(all, [](const std::string& step) { return step.starts_with("noise"); });
  return all;
}

using Words = std::vector<std::string>;

TEST(Cleaning, LeavesASoundRecordingAsItIs) {
  const CleanDemonstration clean = cleaned(recording());
  EXPECT_EQ(clean.demonstration.time, recording().time);
  EXPECT_EQ(clean.demonstration.position, recording().position);
  EXPECT_EQ(clean.steps.size(), 1U);
  EXPECT_LT(clean.noise, 1e-6);
  const Vector speed = clean.demonstration.velocity.rowwise().norm();
  EXPECT_NEAR(speed.maxCoeff(), M_PI / 3, 2e-3);
  EXPECT_NEAR(speed.minCoeff(), M_PI / 3, 2e-3);
}

TEST(Cleaning, DropsSamplesThatAreNotWhole) {
  Recording r = recording();
  r.position(7, 1) = std::nan("");
  r.position(200, 0) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(steps(r), Words{"2 samples with missing, NaN or infinite numbers dropped"});
  EXPECT_EQ(cleaned(r).demonstration.samples(), 299);
  expect_error([&] { cleaned(r, {.missing = false}); }, "arm.csv:9: found a position that is NaN, infinite");
  r.position.topRows(100).setConstant(std::nan(""));
  expect_error([&] { cleaned(r); },
               "arm.csv: found 101 of 301 samples with missing, NaN or infinite numbers; "
               "expected at most 20 %");
  r.position.setConstant(std::nan(""));
  expect_error([&] { cleaned(r, {.most_missing = 1}); }, "found 0 sample(s) that can be used");
}

TEST(Cleaning, MergesRepeatedTimesAndSortsExchangedOnes) {
  Recording r = recording();
  r.time[100] = r.time[99];
  r.time[101] = r.time[99];
  std::swap(r.time[200], r.time[201]);
  r.position.row(200).swap(r.position.row(201));
  EXPECT_EQ(steps(r), (Words{"1 time stamp out of order sorted", "2 repeated time stamps merged"}));
  const Demonstration d = cleaned(r).demonstration;
  EXPECT_EQ(d.samples(), 299);
  EXPECT_TRUE(d.position.row(99).isApprox(recording().position.middleRows(99, 3).colwise().mean()));
  EXPECT_EQ(d.position.row(199), recording().position.row(201));
  expect_error([&] { cleaned(r, {.repeated_times = false}); },
               "arm.csv:102: found time 0.99 after 0.99; expected increasing times");
}

TEST(Cleaning, TimeThatGoesBackIsAnError) {
  Recording r = recording();
  r.time.tail(100).array() -= 2;
  expect_error([&] { cleaned(r); },
               "arm.csv:203: found time 0.01 s after 2 s (1 in all that go back); expected "
               "one demonstration with times in order (more than one in a file: "
               "data.columns.index");
}

TEST(Cleaning, MergesBursts) {
  Recording r = recording();
  for (Eigen::Index i = 1; i < 301; i += 2) r.time[i] = r.time[i + 1] - 5e-6;
  EXPECT_EQ(steps(r), Words{"150 time stamps in bursts merged"});
  const Demonstration d = cleaned(r).demonstration;
  const Vector speed = d.velocity.rowwise().norm();
  EXPECT_NEAR(speed.maxCoeff(), M_PI / 3, 0.05);
  EXPECT_GT(cleaned(r, {.burst = 0, .outlier = 0, .window = 0}).demonstration.velocity.norm(),
            100 * d.velocity.norm());
}

TEST(Cleaning, DropsShortExcursionsAndKeepsCornersAndSpeed) {
  Recording r = recording();
  r.position.row(50).setZero();
  r.position.row(150).array() += 0.4;
  r.position.row(151).array() += 0.4;
  r.position.row(300).array() += 0.5;
  EXPECT_EQ(steps(r), Words{"4 outliers dropped"});
  EXPECT_EQ(cleaned(r).demonstration.samples(), 297);
  EXPECT_EQ(cleaned(r, {.outlier = 0, .rest = 0}).demonstration.samples(), 301);
  Recording corner = recording();  // there and back along a line, and ten times as fast for a while
  for (Eigen::Index i = 0; i < 301; ++i) {
    const double u = static_cast<double>(i) / 300;
    corner.position.row(i) << (u < 0.5 ? u : 1 - u), (u > 0.7 ? 10 * std::min(u - 0.7, 0.1) : 0.0);
  }
  EXPECT_EQ(steps(corner), Words{});
}

TEST(Cleaning, ReportsGapsAndRefusesLargeOnes) {
  const auto without = [](Eigen::Index first, Eigen::Index count) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < 301; ++i)
      if (i < first || i >= first + count) kept.push_back(i);
    return recording().at(kept);
  };
  EXPECT_EQ(steps(without(100, 29)), Words{"1 gap of up to 0.3 s, 10 % of the path"});
  EXPECT_EQ(steps(without(100, 5)), Words{});
  expect_error([&] { cleaned(without(100, 100)); },
               "arm.csv:202: found 1 gap with 32.6 % of the path in them, the longest of 1.01 s; expected at "
               "most 20 %");
  EXPECT_EQ(cleaned(without(100, 100), {.most_in_gaps = 0.5}).demonstration.samples(), 201);
}

TEST(Cleaning, CutsRestAtStartAndEnd) {
  const auto pause = static_cast<Eigen::Index>(100 * kPause);
  Recording r = recording();
  const Recording moving = r;
  r.time = Vector::LinSpaced(301 + 2 * pause, 0, 3 + 2 * kPause);
  r.lines.clear();
  r.position.resize(301 + 2 * pause, 2);
  r.position.topRows(pause).rowwise() = moving.position.row(0);
  r.position.middleRows(pause, 301) = moving.position;
  r.position.bottomRows(pause).rowwise() = moving.position.row(300);
  EXPECT_EQ(steps(r), (Words{"1.2 s of rest at the start cut", "1.2 s of rest at the end cut"}));
  const Demonstration d = cleaned(r).demonstration;
  EXPECT_NEAR(static_cast<double>(d.samples()), 301, 5);
  EXPECT_LT((d.position.bottomRows(1) - moving.position.bottomRows(1)).norm(), 3e-3);
  EXPECT_EQ(cleaned(r, {.rest = 0}).demonstration.samples(), r.samples());
  r.position.setConstant(0.5);
  expect_error([&] { cleaned(r); }, "arm.csv: found a recording that does not move; expected a motion");
}

// A reach of 1 m in `moving` seconds with finite jerk, rest before and after it, and noise; 100 samples a second.
Recording reach(double before, double moving, double after, double noise, unsigned seed) {
  const double duration = before + moving + after;
  const auto samples = static_cast<Eigen::Index>(std::lround(100 * duration)) + 1;
  Recording r{"arm.csv", "t", 0, Vector::LinSpaced(samples, 0, duration), Points::Zero(samples, 2), {}};
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0, 1);
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double u = std::clamp((r.time[i] - before) / moving, 0.0, 1.0);
    const double s = u * u * u * (10 + u * (6 * u - 15));
    r.position.row(i) << s + noise * normal(generator), 0.3 * s * (1 - s) + noise * normal(generator);
  }
  return r;
}

TEST(Cleaning, CutsRestThatIsKnownAndNoMotion) {
  for (const double noise : {0.0, 1e-4, 1e-3, 4e-3}) {
    for (const double moving : {1.0, 4.0, 12.0}) {
      for (const double rest : {0.0, 0.7, 2.0}) {
        SCOPED_TRACE(fmt::format("noise {} m, {} s of motion, {} s of rest", noise, moving, rest));
        const Demonstration d = cleaned(reach(rest, moving, rest, noise, 3)).demonstration;
        const double start = d.time[0], end = d.time[d.samples() - 1];
        // What is lost of the motion is under the noise; what is left of the rest is short beside the motion.
        const auto lost = [&](double u) { return u * u * u * (10 + u * (6 * u - 15)); };
        const double allowed = std::max(1e-5, 0.1 * noise);
        EXPECT_LE(lost(std::max(0.0, (start - rest) / moving)), allowed);
        EXPECT_LE(lost(std::max(0.0, (rest + moving - end) / moving)), allowed);
        const double left = std::max(0.6, 0.12 * moving);  // no rest of less than half a second is cut
        EXPECT_LE(rest - start, left);
        EXPECT_LE(end - rest - moving, left);
        if (rest == 0) {
          EXPECT_EQ(end - start, moving);
        }
      }
    }
  }
}

TEST(Cleaning, KeepsASlowApproachAndCutsTheRestBehindIt) {
  Recording r = reach(0, 4, 0, 0, 1);  // x goes to 1 as 1 - exp(-t / 0.4 s) in place of a reach
  r.position.col(0) = 1 - (-r.time.array() / 0.4).exp();
  r.position.col(1).setZero();
  EXPECT_GE(cleaned(r).demonstration.time[cleaned(r).demonstration.samples() - 1], 0.4 * std::log(1e3));
  const Recording longer = reach(0, 12, 0, 0, 1);
  r.time = longer.time;
  r.position = Points::Zero(r.time.size(), 2);
  r.position.col(0) = 1 - (-r.time.array() / 0.4).exp();
  const Demonstration d = cleaned(r).demonstration;
  EXPECT_LT(d.time[d.samples() - 1], 5);  // within e^-10
  EXPECT_GT(d.position(d.samples() - 1, 0), 1 - 1.5e-4);
}

TEST(Cleaning, RestIsFoundUnderNoise) {
  Recording r = recording();
  r.position.bottomRows(100).rowwise() = r.position.row(200);
  std::mt19937 generator(1);
  std::normal_distribution<double> normal(0, 2e-3);
  for (double& x : r.position.reshaped()) x += normal(generator);
  const CleanDemonstration clean = cleaned(r);
  EXPECT_NEAR(clean.noise, 2e-3, 2e-4);
  EXPECT_GT(clean.demonstration.samples(), 195);
  EXPECT_LT(clean.demonstration.samples(), 210);
}

TEST(Cleaning, VelocitiesAreSmoothAndRecordedOnesStay) {
  Recording r = recording();
  std::mt19937 generator(2);
  std::normal_distribution<double> normal(0, 1e-3);
  for (double& x : r.position.reshaped()) x += normal(generator);
  const Recording exact = recording();
  Points truth(301, 2);
  truth << -exact.position.col(1), exact.position.col(0);
  truth *= M_PI / 3;
  const auto error = [&](const CleaningOptions& options) {
    const Points difference = cleaned(r, options).demonstration.velocity - truth;
    return std::sqrt(difference.middleRows(10, 281).squaredNorm() / (2 * 281));
  };
  // 11 samples 10 ms apart: noise / (h sqrt(110)).
  EXPECT_NEAR(error({.rest = 0}), 1e-3 / (0.01 * std::sqrt(110.0)), 2e-3);
  EXPECT_GT(error({.rest = 0, .window = 0}), 5 * error({.rest = 0}));
  r.velocity = Points::Constant(301, 2, 0.25);
  EXPECT_EQ(cleaned(r, {.rest = 0}).demonstration.velocity, r.velocity);
}

TEST(Cleaning, ResamplesByTimeAndByArcLength) {
  Recording r = recording();
  r.time = (r.time.array().square() / 3).eval();  // slow at first
  r.time[0] = -1e-4;
  const Demonstration by_time =
      cleaned(r, {.burst = 0, .rest = 0, .resample = "time", .samples = 31}).demonstration;
  ASSERT_EQ(by_time.samples(), 31);
  EXPECT_NEAR(by_time.time[1] - by_time.time[0], 0.1, 1e-4);
  EXPECT_NEAR(by_time.time[30] - by_time.time[29], 0.1, 1e-4);
  EXPECT_LT((by_time.position.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-4);
  const CleanDemonstration arc = cleaned(r, {.burst = 0, .rest = 0, .resample = "arc_length", .samples = 21});
  ASSERT_EQ(arc.demonstration.samples(), 21);
  EXPECT_EQ(arc.steps.back(), "resampled to 21 by arc length");
  for (Eigen::Index i = 1; i < 21; ++i) {
    EXPECT_NEAR((arc.demonstration.position.row(i) - arc.demonstration.position.row(i - 1)).norm(), M_PI / 20,
                2e-3);
  }
  EXPECT_TRUE(arc.demonstration.position.row(20).isApprox(r.position.row(300), 1e-9));
}

TEST(LocalParabola, IsExactForParabolasOnUnevenGrids) {
  const Vector t{{0, 0.1, 0.15, 0.4, 0.7, 0.75, 1.1}};
  Points p(7, 2);
  p.col(0) = 3 * t.array().square() - t.array() + 5;
  p.col(1) = -2 * t.array() + 1;
  const LocalParabola fit = fit_parabola(t, p, 1, 5, 0.3);
  EXPECT_TRUE(fit.value.isApprox(Eigen::RowVector2d(3 * 0.09 - 0.3 + 5, 0.4), 1e-12));
  EXPECT_TRUE(fit.slope.isApprox(Eigen::RowVector2d(0.8, -2), 1e-12));
  const SmoothDerivative smooth = smooth_derivative(t, p, 0.5);
  EXPECT_TRUE(smooth.velocity.col(0).isApprox(Vector(6 * t.array() - 1), 1e-10));
  EXPECT_LT(smooth.noise, 1e-12);
}

// Savitzky and Golay's five points: the slope is (-2 p0 - p1 + p3 + 2 p4) / (10 h), the value has weight 17/35.
TEST(LocalParabola, IsSavitzkyAndGolaysOnEvenGrids) {
  const Vector t = Vector::LinSpaced(5, 0, 4);
  Points p = Points::Zero(5, 2);
  p.col(0) << 1, 4, 2, 8, 5;
  const LocalParabola fit = fit_parabola(t, p, 0, 5, 2);
  EXPECT_NEAR(fit.slope[0], (-2 * 1 - 4 + 8 + 2 * 5) / 10.0, 1e-12);
  EXPECT_NEAR(fit.leverage, 17.0 / 35, 1e-12);
}

}  // namespace
}  // namespace s2nnds
