// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/joint_angles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

Recording recording(double from, double to, double wrap) {
  constexpr Eigen::Index samples = 41;
  Recording r{"arm.csv", "t", 0, Vector::LinSpaced(samples, 0, 2), Points(samples, 2), {}};
  r.position.col(0) = Vector::LinSpaced(samples, from, to);
  r.position.col(1).setLinSpaced(samples, 0.2, -0.4);
  for (double& angle : r.position.col(0)) angle -= wrap * std::round(angle / wrap);
  for (Eigen::Index i = 0; i < samples; ++i) r.lines.push_back(i + 2);
  return r;
}

TEST(JointAngles, GoOnWithoutJumps) {
  for (const auto& [turn, unit] :
       {std::pair{2 * M_PI, "rad"}, std::pair{360.0, "deg"}, std::pair{2 * M_PI, ""}}) {
    RecordingSet set{.name = "arm", .unit = unit};
    set.recordings = {recording(0.3 * turn, 0.7 * turn, turn), recording(0.4 * turn, 0.72 * turn, turn)};
    // The second is told a turn lower from its first sample on.
    unwrap_joints(set);
    EXPECT_EQ(set.unit, *unit == '\0' ? "rad" : unit);
    EXPECT_LE((set.recordings[0].position.col(0) - Vector::LinSpaced(41, 0.3 * turn, 0.7 * turn)).norm(),
              1e-9);
    EXPECT_LE((set.recordings[1].position.col(0) - Vector::LinSpaced(41, 0.4 * turn, 0.72 * turn)).norm(),
              1e-9);
    EXPECT_NE(set.report.at(0).find("2 jump(s)"), std::string::npos) << set.report[0];
  }
}

TEST(JointAngles, WholeRecordingsEndTogether) {
  RecordingSet set{.name = "arm", .unit = "rad"};
  set.recordings = {recording(2.0, 3.0, 2 * M_PI), recording(2.9, 3.3, 2 * M_PI)};
  set.recordings.push_back(recording(3.2, 3.25, 2 * M_PI));  // all of it beyond pi: told as -3.08 to -3.03
  unwrap_joints(set);
  EXPECT_NEAR(set.recordings[2].position(0, 0), 3.2, 1e-9);
  EXPECT_NEAR(set.recordings[2].position(40, 0), 3.25, 1e-9);
}

TEST(JointAngles, GapsAndLengthsAreRefusedByRow) {
  RecordingSet set{.name = "arm", .unit = "rad"};
  set.recordings = {recording(-1.5, 1.5, 2 * M_PI)};
  set.recordings[0].position.block(20, 0, 21, 1).array() += 2.5;
  expect_error([&] { unwrap_joints(set); }, "arm.csv:22: found joint 0 at");
  set.unit = "mm";
  expect_error([&] { unwrap_joints(set); }, "found mm with data.state = \"joints\"; expected rad or deg");
}

}  // namespace
}  // namespace s2nnds
