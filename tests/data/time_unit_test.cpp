// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/time_unit.h"

#include <gtest/gtest.h>

#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

// A line of one unit of length, its times `duration` in all from `first` on.
Recording line(double first, double duration, Eigen::Index samples, const std::string& column = "t") {
  Recording r{"line.csv", column, first, Vector::LinSpaced(samples, 0, duration), Points(samples, 2), {}};
  r.position.col(0) = r.time / duration;
  r.position.col(1).setZero();
  return r;
}

double seconds(const std::vector<Recording>& recordings, const std::string& unit = "auto") {
  RecordingSet set{"lines", "", recordings};
  bring_to_seconds(set, unit);
  EXPECT_EQ(set.report.empty(), set.time_unit == 1.0 || unit != "auto");
  EXPECT_NEAR(set.recordings[0].time[1], set.time_unit * recordings[0].time[1],
              1e-15 * recordings[0].time[1]);
  return set.time_unit;
}

TEST(TimeUnit, IsRecognisedByTheSize) {
  EXPECT_EQ(seconds({line(0, 3, 100)}), 1);
  EXPECT_EQ(seconds({line(0, 60, 3000)}), 1);
  EXPECT_EQ(seconds({line(0, 3000, 3000)}), 1e-3);
  EXPECT_EQ(seconds({line(50, 3e6, 120)}), 1e-6);
  EXPECT_EQ(seconds({line(0, 3e9, 120)}), 1e-9);
  EXPECT_EQ(seconds({line(1681292354616358019.0, 3e9, 120)}), 1e-9);
  EXPECT_EQ(seconds({line(1681292354616.0, 300, 30)}),
            1e-3);  // a long time between samples, were it not 2023
  EXPECT_EQ(seconds({line(0, 1, 2)}), 1);
  EXPECT_EQ(seconds({line(0, 3, 100), line(0, 90, 100)}), 1);
}

TEST(TimeUnit, BurstsDoNotLookLikeAnotherUnit) {
  Recording r = line(0, 12, 201);
  for (Eigen::Index i = 1; i < 201; i += 2) r.time[i] = r.time[i + 1] - 5e-6;
  EXPECT_EQ(seconds({r}), 1);
}

TEST(TimeUnit, IsRecognisedByTheColumnsName) {
  EXPECT_EQ(seconds({line(0, 300, 301, "t_ms")}), 1e-3);
  EXPECT_EQ(seconds({line(0, 300, 301, "time [s]")}), 1);
  EXPECT_EQ(seconds({line(0, 3, 100, "stamp.nsec")}), 1e-9);
}

TEST(TimeUnit, IsRecognisedByRecordedVelocities) {
  Recording r = line(0, 300, 301);
  r.velocity = Points::Constant(301, 2, 0);
  r.velocity.col(0).setConstant(1 / 0.3);  // one unit of length in 0.3 s
  EXPECT_EQ(seconds({r}), 1e-3);
  r.velocity.col(0).setConstant(1 / 300.0);
  EXPECT_EQ(seconds({r}), 1);
}

TEST(TimeUnit, IsAskedForWhereItIsNotClear) {
  expect_error([] { seconds({line(0, 300, 301)}); },
               "line.csv: found times that may be s or ms (column 't': 300 in all, steps of 1); expected "
               "data.time_unit");
  EXPECT_EQ(seconds({line(0, 300, 301)}, "s"), 1);
  EXPECT_EQ(seconds({line(0, 300, 301)}, "ms"), 1e-3);
  expect_error([] { seconds({line(0, 3, 100)}, "min"); }, "found 'min'; expected auto, s, ms, us or ns");
}

TEST(TimeUnit, DemonstrationsThatDisagreeAreNamed) {
  expect_error(
      [] {
        seconds({line(0, 3, 100), line(0, 3000, 100)});
      },
      "found times (column 't') as large as ms, those of line.csv as s; expected one unit");
}

}  // namespace
}  // namespace s2nnds
