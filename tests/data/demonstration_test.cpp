// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/demonstration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

Demonstration line(Eigen::Index samples, Eigen::Index dimension) {
  return {Vector::LinSpaced(samples, 0, 1), Points::Random(samples, dimension),
          Points::Random(samples, dimension)};
}

TEST(Demonstration, SoundSetsOfAnyDimensionPass) {
  for (const Eigen::Index n : {2, 3, 6}) {
    const DemonstrationSet set{"lines", "m", {line(2, n), line(5, n)}};
    EXPECT_NO_THROW(check_demonstrations(set, "lines.csv"));
    EXPECT_EQ(set.dimension(), n);
  }
}

TEST(Demonstration, EveryDefectIsNamedWithItsPlace) {
  const auto expect_rejected = [](auto spoil, const std::string& part) {
    DemonstrationSet set{"lines", "m", {line(5, 2), line(5, 2)}};
    spoil(set.demonstrations[1]);
    expect_error([&] { check_demonstrations(set, "lines.csv"); },
                 "lines.csv: demonstration 1: found " + part);
  };
  const double nan = std::nan("");
  const double infinity = std::numeric_limits<double>::infinity();
  expect_rejected([&](Demonstration& d) { d.position(3, 1) = nan; }, "a position that is NaN");
  expect_rejected([&](Demonstration& d) { d.velocity(0, 0) = -infinity; }, "a velocity that is NaN");
  expect_rejected([&](Demonstration& d) { d.time[4] = infinity; }, "a time that is NaN");
  expect_rejected([&](Demonstration& d) { d.time[2] = d.time[1]; }, "time 0.25 at sample 2 after 0.25");
  expect_rejected([&](Demonstration& d) { d = line(1, 2); }, "1 sample(s)");
  expect_rejected([&](Demonstration& d) { d = line(5, 1); }, "dimension 1");
  expect_rejected([&](Demonstration& d) { d = line(5, 3); }, "dimension 3; expected 2");
  expect_rejected([&](Demonstration& d) { d.time = Vector::LinSpaced(4, 0, 1); }, "4 times for 5 positions");
  expect_rejected([&](Demonstration& d) { d.velocity = Points::Zero(4, 2); },
                  "velocities [4, 2]; expected [5, 2]");
}

TEST(Demonstration, AnEmptySetIsRejected) {
  expect_error([] { check_demonstrations({"none", "", {}}, "none.h5"); }, "none.h5: found no demonstrations");
  expect_error([] { DemonstrationSet{"none", "", {}}.dimension(); }, "none: found no demonstrations");
}

TEST(Demonstration, StackingKeepsOrderAndValues) {
  const std::vector<Demonstration> all = {line(3, 2), line(4, 2)};
  const Points positions = stack_positions(all);
  const Points velocities = stack_velocities(all);
  ASSERT_EQ(positions.rows(), 7);
  EXPECT_EQ(positions.topRows(3), all[0].position);
  EXPECT_EQ(positions.bottomRows(4), all[1].position);
  EXPECT_EQ(velocities.topRows(3), all[0].velocity);
  EXPECT_EQ(velocities.bottomRows(4), all[1].velocity);
  EXPECT_EQ(stack_positions({}).size(), 0);
}

}  // namespace
}  // namespace s2nnds
