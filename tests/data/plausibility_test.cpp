// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/plausibility.h"

#include <gtest/gtest.h>

#include "s2nnds/data/readers.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

// A line of this length in this many seconds, one sample a hundredth of it.
Demonstration line(double length, double duration) {
  Demonstration d{Vector::LinSpaced(101, 0, duration), Points::Zero(101, 2), {}};
  d.position.col(0) = Vector::LinSpaced(101, 0, length);
  d.velocity = differentiate(d.time, d.position);
  return d;
}

void check_lines(const std::vector<Demonstration>& lines, const std::string& unit,
                 const PlausibilityOptions& options = {}) {
  check_plausible({"lines", unit, lines}, std::vector<std::string>(lines.size(), "stamp"), options);
}

TEST(Plausibility, WhatArmsDoPasses) {
  EXPECT_NO_THROW(check_lines({line(0.4, 3), line(0.01, 0.3)}, "m"));
  EXPECT_NO_THROW(check_lines({line(400, 3)}, "mm"));
  EXPECT_NO_THROW(check_lines({line(3, 2)}, "rad"));
  EXPECT_NO_THROW(check_lines({line(7, 2)}, ""));
}

TEST(Plausibility, SpeedsBeyondAnyArmNameTheColumn) {
  expect_error(
      [] {
        check_lines({line(0.4, 3), line(0.4, 0.001)}, "m");
      },
      "lines: demonstration 1: found a speed of 400 m/s at ");
  expect_error([] { check_lines({line(0.4, 0.001)}, "m"); },
               "(time column 'stamp'); expected at most 20: time stamps or a unit are wrong");
  expect_error([] { check_lines({line(400, 3)}, "m"); }, "found a speed of 133.3 m/s");  // mm taken for m
  expect_error([] { check_lines({line(1, 0.001)}, ""); }, "found a speed of 1000 units/s");
  EXPECT_NO_THROW(check_lines({line(400, 3)}, "m", {.speed = 200}));
}

TEST(Plausibility, DurationsBeyondAnHourNameTheColumn) {
  expect_error([] { check_lines({line(0.4, 3e9)}, "m"); },
               "demonstration 0: found a duration of 3e+09 s (time column 'stamp'); expected at most 3600 s "
               "(data.time_unit");
  EXPECT_NO_THROW(check_lines({line(0.4, 5000)}, "m", {.duration = 6000}));
}

TEST(Plausibility, UnitsThatDifferBetweenDemonstrations) {
  expect_error(
      [] {
        check_lines({line(0.4, 3), line(400, 3)}, "");
      },
      "lines: found demonstration 0 0.4 and demonstration 1 400 large; expected at most 50 times: one unit");
  expect_error([] { check_lines({line(0, 3)}, "m"); }, "found demonstrations that do not move");
}

TEST(Plausibility, VelocitiesInAnotherUnitThanPositions) {
  Demonstration d = line(400, 3);
  d.velocity /= 1000;  // m/s beside mm
  expect_error([&] { check_lines({d}, "mm"); },
               "demonstration 0: found recorded velocities 0.001 times those that positions and times give");
}

// At 1 kHz the way from sample to sample is mostly noise, though velocities are right.
TEST(Plausibility, NoiseAtAHighRateIsNoOtherUnit) {
  Demonstration d{Vector::LinSpaced(10001, 0, 10), Points::Zero(10001, 2), Points::Zero(10001, 2)};
  d.position.col(0) = Vector::LinSpaced(10001, 0, 0.5);
  d.velocity.col(0).setConstant(0.05);
  for (Eigen::Index i = 0; i < 10001; ++i) d.position(i, 1) = i % 2 == 0 ? 1e-3 : -1e-3;  // 2 m/s
  EXPECT_NO_THROW(check_lines({d}, "m"));
  d.velocity *= 1000;
  expect_error([&] { check_lines({d}, "m"); }, "found a speed of 50 m/s");
  expect_error([&] { check_lines({d}, "m", {.speed = 1e3}); }, "found recorded velocities 1000 times");
}

}  // namespace
}  // namespace s2nnds
