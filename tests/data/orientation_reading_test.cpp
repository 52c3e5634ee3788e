// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/orientation_reading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "s2nnds/data/frame.h"
#include "s2nnds/data/orientation.h"
#include "s2nnds/data/readers.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

// Turned about a skew axis from 1 rad to the goal's orientation, which is no special one.
Eigen::Vector4d shown(double share) {
  const Eigen::Vector4d goal = quaternion_of({0.3, -2.0, 0.8});
  return product(goal, quaternion_of((1.0 - share) * Eigen::Vector3d(0.6, 0.64, 0.48)));
}

class OrientationReading : public testing::Test {
 protected:
  // A row a sample: time, x, y, z and what `numbers` makes of the orientation.
  template <typename Numbers>
  std::string rows(const Numbers& numbers, int samples = 21) const {
    std::string text;
    for (int i = 0; i < samples; ++i) {
      const double s = i / (samples - 1.0);
      text += fmt::format("{:.6g},{},{},{}", 0.1 * i, 1 - s, s * s, 0.5 * s);
      for (const double number : numbers(i, shown(s))) text += fmt::format(",{:.12g}", number);
      text += "\n";
    }
    return text;
  }
  static std::vector<double> xyzw(int, const Eigen::Vector4d& q) { return {q[1], q[2], q[3], q[0]}; }
  static std::vector<double> wxyz(int, const Eigen::Vector4d& q) { return {q[0], q[1], q[2], q[3]}; }

  DemonstrationSet read(const std::string& name, const std::string& text, DataOptions options = {}) const {
    folder_.write(name, text);
    options.source = "csv";
    options.files = {name};
    options.state = "pose";
    options.cleaning.rest = 0;
    return read_demonstrations(options, folder_.path(""));
  }
  void expect_shown(const DemonstrationSet& set) const {
    const Points& q = set.demonstrations.at(0).orientation;
    ASSERT_EQ(q.rows(), 21);
    for (Eigen::Index i = 0; i < q.rows(); ++i) {
      EXPECT_NEAR(angle_between(q.row(i).transpose(), shown(static_cast<double>(i) / 20.0)), 0.0, 1e-7);
      EXPECT_GT(q.row(i).dot(q.row(std::max<Eigen::Index>(i - 1, 0))), 0.9);
    }
  }

  TemporaryFolder folder_;
};

TEST_F(OrientationReading, NamesTellTheOrder) {
  DemonstrationSet set = read("a.csv", "t,x,y,z,qx,qy,qz,qw\n" + rows(xyzw));
  expect_shown(set);
  EXPECT_EQ(set.quaternion_order, "xyzw");
  EXPECT_TRUE(set.has_orientations);
  set = read("b.csv", "t,x,y,z,orientation.w,orientation.x,orientation.y,orientation.z\n" + rows(wxyz));
  expect_shown(set);
  EXPECT_EQ(set.quaternion_order, "wxyz");
}

// In the wrong order all angles between orientations are the same: nothing but names or the user can tell.
TEST_F(OrientationReading, NumberedColumnsNeedTheOrder) {
  DataOptions options;
  options.columns.time = "0";
  options.columns.position = {"1", "2", "3"};
  options.columns.quaternion = {"4", "5", "6", "7"};
  expect_error([&] { read("a.csv", rows(xyzw), options); }, "nothing that tells their order");
  options.quaternion_order = "xyzw";
  expect_shown(read("a.csv", rows(xyzw), options));
  const DemonstrationSet wrong = read("b.csv", rows(wxyz), options);
  const Points& q = wrong.demonstrations.at(0).orientation;
  EXPECT_NEAR(angle_between(q.row(0).transpose(), q.row(20).transpose()), angle_between(shown(0), shown(1)),
              1e-7);
  EXPECT_GT(angle_between(q.row(0).transpose(), shown(0)), 0.1);
  options.quaternion_order = "wxyz";
  const DemonstrationSet set = read("b.csv", rows(wxyz), options);
  expect_shown(set);
  EXPECT_EQ(set.quaternion_order, "wxyz");
}

TEST_F(OrientationReading, UndoesSignsAndNorms) {
  const auto flipped = [](int i, const Eigen::Vector4d& q) {
    const double size = i % 3 == 0 ? -1.02 : 0.99;
    return xyzw(i, size * q);
  };
  const DemonstrationSet set = read("a.csv", "t,x,y,z,qx,qy,qz,qw\n" + rows(flipped));
  expect_shown(set);
  EXPECT_NE(set.report.at(1).find("13 change(s) between q and -q undone"), std::string::npos)
      << set.report[1];
  EXPECT_NE(set.report[1].find("by up to 0.02 made 1"), std::string::npos) << set.report[1];
}

TEST_F(OrientationReading, TakesRotationMatrices) {
  const auto matrix = [](int, const Eigen::Vector4d& q) {
    const Points m = rotation_matrix(q);
    return std::vector<double>(m.data(), m.data() + 9);
  };
  DataOptions options;
  options.columns.rotation = {"a", "b", "c", "d", "e", "f", "g", "h", "i"};
  const std::string head = "t,x,y,z,a,b,c,d,e,f,g,h,i\n";
  expect_shown(read("a.csv", head + rows(matrix), options));
  const auto mirrored = [&](int i, const Eigen::Vector4d& q) {
    std::vector<double> m = matrix(i, q);
    if (i == 4) m[0] = -m[0], m[3] = -m[3], m[6] = -m[6];
    return m;
  };
  expect_error([&] { read("a.csv", head + rows(mirrored), options); },
               "a.csv:6: found a matrix with determinant -1");
}

TEST_F(OrientationReading, BadRowsAreNamed) {
  const std::string head = "t,x,y,z,qx,qy,qz,qw\n";
  const auto zero = [](int i, const Eigen::Vector4d& q) { return xyzw(i, i == 7 ? 0.0 * q : q); };
  expect_error([&] { read("a.csv", head + rows(zero)); },
               "a.csv:9: found a quaternion of norm 0; expected 1");
  const auto mixed = [](int i, const Eigen::Vector4d& q) { return i < 12 ? xyzw(i, q) : wxyz(i, q); };
  expect_error([&] { read("a.csv", head + rows(mixed)); },
               "if the numbers were wxyz from here on; expected one order throughout");
  const auto jump = [](int i, const Eigen::Vector4d& q) {
    return xyzw(i, i < 12 ? product(q, quaternion_of({0, 1.5, 0})) : q);
  };
  expect_error([&] { read("a.csv", head + rows(jump)); }, "a.csv:14: found a turn of");
  const auto around = [](int i, const Eigen::Vector4d&) {
    return xyzw(i, quaternion_of({0.0, 0.0, M_PI * (1.0 - i / 20.0)}));
  };
  expect_error([&] { read("a.csv", head + rows(around)); },
               "a.csv:2: found an orientation turned by 180 degrees");
  expect_error([&] { read("a.csv", "t,x,y,z\n0,0,0,0\n1,1,1,1\n"); },
               "found no orientations; expected data.columns");
  DataOptions options;
  options.quaternion_order = "wxyz";
  expect_error([&] { read("a.csv", head + rows(xyzw), options); },
               "found wxyz, but the columns are named xyzw");
}

TEST_F(OrientationReading, MissingNumbersAreDroppedAndSamplesThinned) {
  std::string text = "t,x,y,z,qx,qy,qz,qw\n" + rows(xyzw, 41);
  const auto place = text.find("\n0.3,");
  ASSERT_NE(place, std::string::npos);
  const auto end = text.find('\n', place + 1);
  text = text.substr(0, text.rfind(',', end)) + ",NA" + text.substr(end);
  DataOptions options;
  options.stride = 2;
  const Demonstration d = read("a.csv", text, options).demonstrations.at(0);
  EXPECT_EQ(d.orientation.rows(), d.samples());
  EXPECT_EQ(static_cast<Eigen::Index>(d.lines.size()), d.samples());
  EXPECT_EQ(d.lines.back(), 42);
}

TEST_F(OrientationReading, PositionsAloneAreReadAsBefore) {
  folder_.write("a.csv", "t,x,y,z,qx,qy,qz,qw\n" + rows(xyzw));
  DataOptions options;
  options.source = "csv";
  options.files = {"a.csv"};
  const DemonstrationSet set = read_demonstrations(options, folder_.path(""));
  EXPECT_EQ(set.demonstrations[0].orientation.size(), 0);
  EXPECT_TRUE(set.has_orientations);
  EXPECT_FALSE(find_frame(set, "max_abs").has_orientation());
}

TEST_F(OrientationReading, TheGoalIsTheMeanOfTheEndsWhichMustBeAlike) {
  const auto turned = [](double angle) {
    return [angle](int i, const Eigen::Vector4d& q) {
      return xyzw(i, product(quaternion_of({0, 0, angle}), q));
    };
  };
  const std::string head = "t,x,y,z,qx,qy,qz,qw\n";
  folder_.write("p0.csv", head + rows(turned(0.1)));
  folder_.write("p1.csv", head + rows(turned(-0.1)));
  DataOptions options;
  options.source = "csv";
  options.state = "pose";
  options.files = {"p0.csv", "p1.csv"};
  const Frame frame = find_frame(read_demonstrations(options, folder_.path("")), "max_abs");
  EXPECT_LE(angle_between(frame.goal_orientation, shown(1.0)), 1e-6);
  EXPECT_EQ(frame.quaternion_order, "xyzw");
  folder_.write("p1.csv", head + rows(turned(-1.0)));
  expect_error([&] { find_frame(read_demonstrations(options, folder_.path("")), "max_abs"); },
               "demonstration 0 ends turned by 32 degrees from the mean of all ends");
}

}  // namespace
}  // namespace s2nnds
