// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/readers.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "s2nnds/data/handwriting.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

// Uneven times in [0, 2].
Vector uneven(Eigen::Index samples) {
  Vector time(samples);
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(samples - 1);
    time[i] = 2 * u + 0.2 * std::sin(6 * u) - 0.2 * std::sin(6.0) * u;
  }
  return time;
}

TEST(Differentiate, IsExactForParabolasOnAnyGrid) {
  const Vector t = uneven(9);
  Points p(9, 2);
  p.col(0) = 3 * t.array().square() - t.array() + 5;
  p.col(1) = -2 * t.array() + 1;
  const Points v = differentiate(t, p);
  EXPECT_TRUE(v.col(0).isApprox(Vector(6 * t.array() - 1), 1e-12));
  EXPECT_TRUE(v.col(1).isApprox(Vector::Constant(9, -2), 1e-12));
}

TEST(Differentiate, ErrorFallsWithTheSquareOfTheStep) {
  const auto error = [](Eigen::Index samples) {
    const Vector t = uneven(samples);
    Points p(samples, 2);
    p.col(0) = t.array().sin();
    p.col(1) = t.array().exp();
    const Points v = differentiate(t, p);
    return std::max((v.col(0) - Vector(t.array().cos())).cwiseAbs().maxCoeff(),
                    (v.col(1) - p.col(1)).cwiseAbs().maxCoeff());
  };
  const double order = std::log2(error(201) / error(401));
  EXPECT_GT(order, 1.9);
  EXPECT_LT(order, 2.1);
}

TEST(Differentiate, TwoSamplesGiveTheirSlopeAndFewerAnError) {
  EXPECT_EQ(differentiate(Vector({{1, 3}}), Points{{0, 1}, {4, 0}}), (Points{{2, -0.5}, {2, -0.5}}));
  expect_error([] { differentiate(Vector::Zero(1), Points::Zero(1, 2)); }, "found 1 times and 1 positions");
  expect_error([] { differentiate(Vector::LinSpaced(3, 0, 1), Points::Zero(2, 2)); },
               "found 3 times and 2 positions");
  expect_error(
      [] {
        differentiate(Vector({{0, 0, 1}}), Points::Zero(3, 2));
      },
      "found time 0 at sample 1 after 0");
}

class ReadDemonstrations : public testing::Test {
 protected:
  TemporaryFolder folder_;
  DataOptions csv_;

  void SetUp() override {
    // The robot's layout: a row a millisecond, a clock that has been running, a goal somewhere.
    std::string text = "time,x,y,dx,dy\n";
    for (int i = 0; i <= 25; ++i) {
      text += fmt::format("{:.3f},{},{},{},0\n", 100 + 0.001 * i, 0.5 - 0.01 * i, 0.3, -10);
    }
    folder_.write("robot.csv", text);
    csv_.source = "csv";
    csv_.files = {"robot.csv"};
    csv_.stride = 10;
    csv_.unit = "m";
    csv_.test = {};
  }
};

TEST_F(ReadDemonstrations, ThinsTheRobotsRecordingsAndLeavesThemInTheirFrame) {
  const DemonstrationSet set = read_demonstrations(csv_, folder_.path(""));
  EXPECT_EQ(set.unit, "m");
  const Demonstration& d = set.demonstrations.at(0);
  EXPECT_TRUE(d.time.isApprox(Vector({{100, 100.01, 100.02, 100.025}}), 1e-9));
  EXPECT_TRUE(d.position.isApprox(Points{{0.5, 0.3}, {0.4, 0.3}, {0.3, 0.3}, {0.25, 0.3}}, 1e-12));
  EXPECT_EQ(d.velocity.col(0), Vector::Constant(4, -10));
}

TEST_F(ReadDemonstrations, AbsolutePathsDoNotNeedADataDirectory) {
  csv_.files = {folder_.path("robot.csv")};
  EXPECT_EQ(read_demonstrations(csv_, "").demonstrations.size(), 1U);
}

TEST_F(ReadDemonstrations, PicksTheOnesInUse) {
  DataOptions options;
  options.motion = "Helix";
  options.use = {3, 0};
  options.stride = 10;
  const DemonstrationSet all = handwriting("Helix");
  const DemonstrationSet set = read_demonstrations(options, "");
  ASSERT_EQ(set.demonstrations.size(), 2U);
  EXPECT_EQ(set.demonstrations[0].samples(), 101);
  EXPECT_EQ(set.demonstrations[0].position.row(1), all.demonstrations[3].position.row(10));
  EXPECT_EQ(set.demonstrations[1].velocity.row(1), all.demonstrations[0].velocity.row(10));
  options.use = {7};
  expect_error([&] { read_demonstrations(options, ""); }, "found index 7; expected 0 to 6");
}

TEST_F(ReadDemonstrations, BadOptionsAreNamed) {
  DataOptions options;
  options.source = "lasa";
  expect_error([&] { read_demonstrations(options, ""); }, "found source 'lasa' without a file");
  options.file = "lasa/Cosine.mat";
  expect_error([&] { read_demonstrations(options, folder_.path("")); },
               "lasa/Cosine.mat: found no such file");
  expect_error([&] { read_demonstrations(options, folder_.path("")); }, "--data DIR or S2NNDS_DATA");
  csv_.files = {};
  expect_error([&] { read_demonstrations(csv_, ""); }, "found no files");
  csv_.stride = 0;
  expect_error([&] { read_demonstrations(csv_, ""); }, "stride");
  options.source = "paper";
  expect_error([&] { read_demonstrations(options, ""); }, "source");
}

// Recordings as people have them: from files to demonstrations, and what is reported.
class RawRecordings : public testing::Test {
 protected:
  // A curve in 3 s with 100 samples, a line each by `row` (time from 0 to 3, x, y).
  template <typename Row>
  void write(const std::string& name, const std::string& header, Row row) const {
    std::string text = header;
    for (int i = 0; i < 100; ++i) {
      const double u = i / 99.0;
      text += row(3 * u, 0.4 * u, 0.1 * std::sin(3 * u));
    }
    folder_.write(name, text);
  }
  void write_seconds(const std::string& name, double scale = 1) const {
    write(name, "time,x,y\n",
          [&](double t, double x, double y) { return fmt::format("{},{},{}\n", t, scale * x, scale * y); });
  }
  DataOptions files(const std::vector<std::string>& names) const {
    DataOptions options;
    options.source = "csv";
    options.files = names;
    options.unit = "m";
    return options;
  }
  DemonstrationSet read(const DataOptions& options) const {
    return read_demonstrations(options, folder_.path(""));
  }

  TemporaryFolder folder_;
};

TEST_F(RawRecordings, NanosecondsAreRecognisedAndReported) {
  for (const char* name : {"d0.csv", "d1.csv"}) {
    write(name, "%time,field.pose.position.x,field.pose.position.y\n", [](double t, double x, double y) {
      return fmt::format("{},{},{}\n", 1681292354616358019 + static_cast<std::int64_t>(1e9 * t), x, y);
    });
  }
  const DemonstrationSet set = read(files({"d*.csv"}));
  ASSERT_EQ(set.demonstrations.size(), 2U);
  EXPECT_NEAR(set.demonstrations[0].time[99] - set.demonstrations[0].time[0], 3, 1e-8);
  EXPECT_NEAR(set.demonstrations[0].velocity(50, 0), 0.4 / 3, 1e-4);
  EXPECT_EQ(set.report.at(1),
            "time column 'time' taken as ns (by its size, counted from 1970); data.time_unit "
            "says otherwise");
  DataOptions stated = files({"d0.csv"});
  stated.time_unit = "s";
  expect_error([&] { read(stated); },
               "found a duration of 3e+09 s (time column 'time'); expected at most 3600 s");
}

TEST_F(RawRecordings, BurstsGiveTheRecordedSpeedOrAnErrorThatNamesTheColumn) {
  double last = 0;
  write("d0.csv", "time,x,y\n", [&, k = 0](double t, double x, double y) mutable {
    last = k++ % 2 == 0 ? t : last + 5e-6;
    return fmt::format("{},{},{}\n", last, x, y);
  });
  const DemonstrationSet set = read(files({"d0.csv"}));
  EXPECT_LT(set.demonstrations[0].velocity.rowwise().norm().maxCoeff(), 0.25);
  EXPECT_EQ(set.report.at(1).substr(0, 36), "0: 50 time stamps in bursts merged, ");
  DataOptions off = files({"d0.csv"});
  off.cleaning.steps = "off";
  expect_error([&] { read(off); }, "demonstration 0: found a speed of");
  expect_error([&] { read(off); }, "(time column 'time'); expected at most 20");
}

TEST_F(RawRecordings, FoldersAndPatternsInOrderOfNumber) {
  write_seconds("d2.csv", 2);
  write_seconds("d10.csv", 10);
  folder_.write("notes.md", "not data");
  for (const char* name : {".", "d*.csv", "d[0-9]*.csv"}) {
    const DemonstrationSet set = read(files({name}));
    ASSERT_EQ(set.demonstrations.size(), 2U) << name;
    EXPECT_NEAR(set.demonstrations[1].position(99, 0), 4, 1e-12);
  }
  std::filesystem::create_directory(folder_.path("empty"));
  expect_error([&] { read(files({"empty"})); },
               "empty: found no files that end in .csv, .txt, .tsv, .dat; expected");
  expect_error([&] { read(files({"e*.csv"})); },
               "found no files as 'e*.csv'; expected at least one (data.files)");
  expect_error([&] { read(files({"d3.csv"})); },
               "d3.csv: found no such file; expected it in the data directory");
}

TEST_F(RawRecordings, UnitsThatDifferAreAnError) {
  write_seconds("a.csv");
  write_seconds("b.csv", 1000);
  expect_error([&] { read(files({"a.csv", "b.csv"})); }, "found demonstration 0 0.4");
  expect_error([&] { read(files({"b.csv"})); }, "found a speed of 1");  // mm taken for m
  DataOptions millimetres = files({"b.csv"});
  millimetres.unit = "mm";
  EXPECT_EQ(read(millimetres).demonstrations.size(), 1U);
}

TEST_F(RawRecordings, SmallSets) {
  write_seconds("a.csv");
  EXPECT_EQ(read(files({"a.csv"})).demonstrations.size(), 1U);
  folder_.write("two.csv", "time,x,y\n0,0,0\n1,1,0.5\n");
  EXPECT_TRUE(read(files({"two.csv"})).demonstrations[0].velocity.isApprox(Points{{1, 0.5}, {1, 0.5}}));
  folder_.write("one.csv", "time,x,y\n0,0,0\n");
  expect_error([&] { read(files({"one.csv"})); }, "one.csv:2: found 1 sample(s)");
  write("c.csv", "time,x,y,z\n",
        [](double t, double x, double y) { return fmt::format("{},{},{},0\n", t, x, y); });
  expect_error([&] { read(files({"a.csv", "c.csv"})); }, "c.csv: found 3 position columns; expected 2");
}

TEST_F(RawRecordings, AMillionSamplesInSecondsWithProgress) {
  std::string text = "time,x,y\n";
  for (int i = 0; i < 1'000'000; ++i)
    text +=
        fmt::format("{:.4f},{:.6f},{:.6f}\n", 1e-4 * i, 0.3 * std::sin(1e-5 * i), 0.3 * std::cos(1e-5 * i));
  folder_.write("long.csv", text);
  int lines = 0;
  const auto begin = std::chrono::steady_clock::now();
  const DemonstrationSet set = read_demonstrations(files({"long.csv"}), folder_.path(""),
                                                   [&](const std::string&, double) { ++lines; });
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(set.demonstrations[0].samples(), 1'000'000);
  EXPECT_EQ(lines, 5);  // four while reading, one of cleaning
  RecordProperty("seconds", std::to_string(seconds.count()));
}

TEST(DataOptions, OnlyTheKeysOfTheSourceAreKnown) {
  DataOptions options;
  read_toml(
      "source = \"csv\"\nfiles = [\"a.csv\", \"b.csv\"]\nunit = \"m\"\nstride = 10\ntest = [1]\nuse = [1, "
      "0]\n"
      "normalization = \"max_norm\"",
      "run.toml", options);
  DataOptions again;
  read_toml(to_toml(options), "again.toml", again);
  EXPECT_EQ(again.source, "csv");
  EXPECT_EQ(again.files, (std::vector<std::string>{"a.csv", "b.csv"}));
  EXPECT_EQ(again.unit, "m");
  EXPECT_EQ(again.stride, 10);
  EXPECT_EQ(again.test, (std::vector<std::int64_t>{1}));
  EXPECT_EQ(again.use, (std::vector<std::int64_t>{1, 0}));
  EXPECT_EQ(again.normalization, "max_norm");
  const auto read = [](const std::string& text) {
    DataOptions fresh;
    read_toml(text, "run.toml", fresh);
  };
  expect_error([&] { read("source = \"csv\"\nmotion = \"Sine\""); }, "motion");
  expect_error([&] { read("source = \"lasa\"\nfiles = [\"a.mat\"]"); }, "files");
  expect_error([&] { read("motion = \"Cosine\""); }, "Cosine");
  expect_error([&] { read("stride = 0"); }, "stride");
  expect_error([&] { read("test = [-2]"); }, "test");
}

TEST(DataDirectory, FlagThenEnvironmentThenSharedFolder) {
  const TemporaryFolder folder;
  const std::string named = folder.path("");
  unsetenv("S2NNDS_DATA");
  EXPECT_EQ(data_directory(named), named);
  expect_error([&] { data_directory(folder.path("none")); },
               "none: found no such directory; expected --data");
  setenv("S2NNDS_DATA", named.c_str(), 1);
  EXPECT_EQ(data_directory(""), named);
  EXPECT_EQ(data_directory("/"), "/");
  setenv("S2NNDS_DATA", folder.path("none").c_str(), 1);
  expect_error([] { data_directory(""); }, "expected S2NNDS_DATA");
  unsetenv("S2NNDS_DATA");

  const auto before = std::filesystem::current_path();
  std::filesystem::create_directories(folder.path("shared/data"));
  std::filesystem::create_directories(folder.path("main"));
  std::filesystem::current_path(folder.path("main"));
  EXPECT_EQ(data_directory(""), "../shared/data");
  std::filesystem::current_path(folder.path(""));
  EXPECT_TRUE(data_directory("").empty() || std::filesystem::is_directory("../shared/data"));
  std::filesystem::current_path(before);
}

}  // namespace
}  // namespace s2nnds
