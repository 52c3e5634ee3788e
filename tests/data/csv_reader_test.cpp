// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdint>
#include <locale>

#include "s2nnds/data/readers.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

class CsvReader : public testing::Test {
 protected:
  Demonstration read(const std::string& text, std::int64_t stride = 1) const {
    return make_demonstrations(read_csv({folder_.write("one.csv", text)}), stride).demonstrations.at(0);
  }
  void expect_rejected(const std::string& text, const std::string& part) const {
    expect_error([&] { read(text); }, part);
  }

  TemporaryFolder folder_;
};

TEST_F(CsvReader, ReadsPositionsAndVelocities) {
  const Demonstration d = read("time,x,y,dx,dy\n0.5,1,-2,3,4e-1\n0.501,1.5,-2.5,+3.5,.25\n");
  EXPECT_EQ(d.time, Vector({{0.5, 0.501}}));
  EXPECT_EQ(d.position, Points({{1, -2}, {1.5, -2.5}}));
  EXPECT_EQ(d.velocity, Points({{3, 0.4}, {3.5, 0.25}}));
}

TEST_F(CsvReader, TakesWindowsLinesBlanksAndAByteOrderMark) {
  const Demonstration d = read("\xEF\xBB\xBFtime, x, y, z\r\n0, 1, 2, 3\r\n1, 2, 4, 6\r\n\r\n");
  EXPECT_EQ(d.position, Points({{1, 2, 3}, {2, 4, 6}}));
  EXPECT_EQ(d.velocity, Points({{1, 2, 3}, {1, 2, 3}}));
}

TEST_F(CsvReader, ReadsAnyDimensionByNumberedColumns) {
  const Demonstration d = read("time,x1,x2,x3,x4,dx1,dx2,dx3,dx4\n0,1,2,3,4,5,6,7,8\n1,0,0,0,0,0,0,0,0");
  EXPECT_EQ(d.position.row(0), Eigen::RowVector4d(1, 2, 3, 4));
  EXPECT_EQ(d.velocity.row(0), Eigen::RowVector4d(5, 6, 7, 8));
}

TEST_F(CsvReader, StrideKeepsTheLastSampleAndDifferentiatesWhatIsLeft) {
  // x = t^2 with one wrong sample that thinning leaves out.
  const Demonstration d = read("time,x,y\n0,0,0\n1,99,0\n2,4,0\n3,9,0\n4,16,0\n5,25,0\n", 2);
  EXPECT_EQ(d.time, Vector({{0, 2, 4, 5}}));
  EXPECT_TRUE(d.velocity.col(0).isApprox(Vector({{0, 4, 8, 10}}), 1e-14));
  EXPECT_EQ(read("time,x,y\n0,0,0\n1,1,1\n2,4,0\n", 100).samples(), 2);
}

TEST_F(CsvReader, ALocaleWithDecimalCommasChangesNothing) {
  struct Commas : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new Commas));
  const Demonstration d = read("time,x,y\n0,1.5,2000.25\n1,0,0\n");
  std::locale::global(before);
  EXPECT_EQ(d.position.row(0), Eigen::RowVector2d(1.5, 2000.25));
}

TEST_F(CsvReader, OneFileADemonstrationAllOfOneDimension) {
  const std::string a = folder_.write("a.csv", "time,x,y\n0,1,2\n1,0,0\n");
  const std::string b = folder_.write("b.csv", "time,x,y\n0,3,2\n1,0,0\n2,0,1\n");
  const DemonstrationSet set = make_demonstrations(read_csv({a, b}));
  EXPECT_EQ(set.name, "a");
  ASSERT_EQ(set.demonstrations.size(), 2U);
  EXPECT_EQ(set.demonstrations[1].samples(), 3);
  const std::string c = folder_.write("c.csv", "time,x,y,z\n0,1,2,3\n1,0,0,0\n");
  expect_error([&] { read_csv({a, c}); }, "c.csv: found 3 position columns; expected 2 as in ");
}

TEST_F(CsvReader, RecognisesTheUsualNames) {
  const Points position{{1, 2}, {3, 5}, {4, 7}};
  const auto expect_read = [&](const std::string& text, const std::string& chosen, bool velocity = false) {
    const RecordingSet set = read_csv({folder_.write("one.csv", text)});
    EXPECT_EQ(set.recordings.at(0).position, position) << text;
    EXPECT_EQ(set.recordings.at(0).velocity.size() > 0, velocity) << text;
    EXPECT_EQ(set.report.at(0), "columns of one: " + chosen);
  };
  expect_read(
      "%time,field.header.seq,field.pose.position.x,field.pose.position.y,field.pose.orientation.x,"
      "field.pose.orientation.y\n0,7,1,2,0,0\n1,8,3,5,0,0\n2,9,4,7,0,0\n",
      "time 'time', position 'field.pose.position.x', 'field.pose.position.y', no velocity, not used "
      "'field.header.seq', 'field.pose.orientation.x', 'field.pose.orientation.y'");
  expect_read("t;px;py;vx;vy\n0;1;2;0;0\n1;3;5;0;0\n2;4;7;0;0\n",
              "time 't', position 'px', 'py', velocity 'vx', 'vy', delimiter: semicolon", true);
  expect_read(
      "Time frame pos_x pos_y qx qy qz qw\n0 base 1 2 0 0 0 1\n1 base 3 5 0 0 0 1\n2 base 4 7 0 0 0 1",
      "time 'Time', position 'pos_x', 'pos_y', no velocity, not used 'frame', 'qx', 'qy', 'qz', 'qw', "
      "delimiter: blanks");
  expect_read("\"timestamp_s\"\t\"x [mm]\"\t\"y [mm]\"\n0\t1\t2\n1\t3\t5\n2\t4\t7\n",
              "time 'timestamp_s', position 'x [mm]', 'y [mm]', no velocity, delimiter: tab");
  expect_read(
      "__time,/robot/position/x,/robot/position/y,/robot/twist/linear/x,/robot/twist/linear/y\n"
      "0,1,2,1,1\n1,3,5,1,1\n2,4,7,1,1\n",
      "time '__time', position '/robot/position/x', '/robot/position/y', velocity "
      "'/robot/twist/linear/x', '/robot/twist/linear/y'",
      true);
  expect_read("# recorded on a Monday\n# time q1 q2 dq1 dq2\n0 1 2 0 0\n1 3 5 0 0\n2 4 7 0 0\n",
              "time 'time', position 'q1', 'q2', velocity 'dq1', 'dq2', delimiter: blanks", true);
  expect_read("0.0,1,2\n1,3,5\n2,4,7\n",
              "time '0', position '1', '2', no velocity, no header, data from line 1");
  expect_read("0,1,2\n0,1,2\n1,3,5\n2,4,7\n",
              "time '0', position '1', '2', no velocity, no header, data from line 2");
  expect_read("t;x;y\n0,0;1,0;2,0\n1,0;3,0;5,0\n# a pause\n2,0;4,0;7,0\n",
              "time 't', position 'x', 'y', no velocity, delimiter: semicolon");
}

TEST_F(CsvReader, TheUnitInANameIsKept) {
  EXPECT_EQ(read_csv({folder_.write("one.csv", "t_ms,x [mm],y [mm]\n0,1,2\n1,3,5\n")}).unit, "mm");
  EXPECT_EQ(read_csv({folder_.write("one.csv", "t_ms,x_m,y_m\n0,1,2\n1,3,5\n")}).unit, "m");
}

TEST_F(CsvReader, ColumnsByNameOrNumber) {
  const std::string path = folder_.write("one.csv", "a,b,c,d,e\n9,1,0,2,5\n9,3,1,5,6\n");
  TableOptions options;
  options.columns.time = "c";
  options.columns.position = {"b", "3"};
  options.columns.velocity = {"a", "e"};
  const Recording read = read_csv({path}, options).recordings.at(0);
  EXPECT_EQ(read.time, Vector({{0, 1}}));
  EXPECT_EQ(read.position, Points({{1, 2}, {3, 5}}));
  EXPECT_EQ(read.velocity, Points({{9, 5}, {9, 6}}));
  options.columns.position = {"b", "f"};
  expect_error(
      [&] { read_csv({path}, options); },
      "one.csv:1: found the 5 columns 'a', 'b', 'c', 'd', 'e'; expected 'f' as data.columns.position");
  options.columns.position = {"b", "5"};
  expect_error([&] { read_csv({path}, options); }, "expected '5' as data.columns.position");
  options.columns.position = {"b"};
  expect_error([&] { read_csv({path}, options); }, "found 1 position column(s); expected at least 2");
  options.columns.position = {"b", "d"};
  options.columns.velocity = {"a"};
  expect_error([&] { read_csv({path}, options); }, "found 1 velocity column(s) for 2 position columns");
}

TEST_F(CsvReader, WithoutTimesARateCounts) {
  TableOptions options;
  options.rate = 4;
  const RecordingSet set = read_csv({folder_.write("one.csv", "1 2\n3 5\n4 7\n")}, options);
  EXPECT_EQ(set.time_unit, 1);
  EXPECT_EQ(set.recordings.at(0).time, Vector({{0, 0.25, 0.5}}));
  EXPECT_EQ(set.recordings.at(0).position, Points({{1, 2}, {3, 5}, {4, 7}}));
}

TEST_F(CsvReader, SeveralDemonstrationsInAFile) {
  const auto read = [&](const std::string& text) {
    return read_csv({folder_.write("all.csv", text)}).recordings;
  };
  const std::vector<Recording> by_index =
      read("episode,t,x,y\n3,0,1,2\n3,1,2,3\n\n1,0,5,6\n1,0.5,7,8\n1,0.7,9,9\n");
  ASSERT_EQ(by_index.size(), 2U);
  EXPECT_EQ(by_index[1].position, Points({{5, 6}, {7, 8}, {9, 9}}));
  EXPECT_EQ(by_index[1].place(0), folder_.path("all.csv") + ":5");
  const std::vector<Recording> by_blanks = read("t,x,y\n0,1,2\n1,2,3\n\n\n0,5,6\n1,7,8\n\n");
  ASSERT_EQ(by_blanks.size(), 2U);
  EXPECT_EQ(by_blanks[1].position, Points({{5, 6}, {7, 8}}));
  EXPECT_EQ(read("t,x,y\n\n0,1,2\n\n1,2,3\n\n2,5,6\n").size(), 1U);  // the time runs on
  expect_error([&] { read("episode,t,x,y\n3,0,1,2\n3,1,2,3\n1,0,5,6\n1,2,5,6\n3,0,1,1\n"); },
               "all.csv:6: found index '3' again after another");
  expect_error([&] { read("episode,t,x,y\n3,0,1,2\n3,1,2,3\n1,0,5,6\n"); },
               "all.csv:4: found 1 sample(s) in a demonstration; expected at least 2");
}

TEST_F(CsvReader, NanosecondsSince1970KeepTheirDifferences) {
  const RecordingSet set =
      read_csv({folder_.write("one.csv", "t,x,y\n1681292354616358019,1,2\n1681292354616358020,3,5\n")});
  EXPECT_EQ(set.recordings.at(0).time, Vector({{0, 1}}));
  EXPECT_EQ(set.recordings.at(0).time_offset, 1681292354616358019.0);
}

TEST_F(CsvReader, BadHeaders) {
  expect_rejected("", "one.csv:1: found no line of data; expected a table of numbers");
  expect_rejected("# nothing\n\n", "one.csv:1: found no line of data");
  expect_rejected("a,x,y\n0,1,2\n",
                  "one.csv:1: found the columns 'a', 'x', 'y'; expected a time column: name it by "
                  "data.columns.time, or give data.rate");
  expect_rejected("\n\ntime,x\n0,1\n", "one.csv:3: found the columns 'time', 'x'; expected position columns");
  expect_rejected("t,left_x,left_y,right_x,right_y\n", "found more than one group of position columns");
  expect_rejected("9,1,2,3,4,5\n", "one.csv:1: found no header and 6 columns; expected data.columns");
  expect_rejected(std::string("\x01\x02\0\x7f", 4), "found the columns '\?\?\?");
}

TEST_F(CsvReader, BadRowsAreNamedByFileAndLine) {
  const std::string head = "time,x,y\n0,1,2\n";
  expect_rejected(head + "1,2\n", "one.csv:3: found 2 values; expected 3 as in the header");
  expect_rejected(head + "\n1,2,3,4\n", "one.csv:4: found 4 values; expected 3");
  expect_rejected(head + "1,nan,3\n", "one.csv:3: found a position that is NaN, infinite or missing");
  expect_rejected(head + "1,2,inf\n", "one.csv:3: found a position that is NaN");
  expect_rejected(head + "1,2,-Inf\n", "one.csv:3: found a position that is NaN");
  expect_rejected(head + "1,,3\n", "one.csv:3: found a position that is NaN");
  expect_rejected(head + "1,2,1e999\n", "one.csv:3: found '1e999'; expected a number");
  expect_rejected(head + "1,2,3 4\n", "one.csv:3: found '3 4'");
  expect_rejected(head + "1,2,0x10\n", "one.csv:3: found '0x10'");
  expect_rejected(head + "1;2;3\n", "one.csv:3: found 1 values");
  expect_rejected(head + "0,2,3\n", "one.csv:3: found time 0 after 0; expected increasing times");
  expect_rejected(head + "1,2,3\n0.5,2,3\n", "one.csv:4: found time 0.5 after 1; expected increasing times");
  expect_rejected(head, "one.csv:2: found 1 sample(s) in the file; expected at least 2");
  expect_rejected("time,x,y\n", "one.csv:1: found 0 sample(s)");
}

TEST_F(CsvReader, FilesThatCannotBeRead) {
  expect_error([&] { read_csv({folder_.path("none.csv")}); }, "none.csv: found no such file");
  expect_error([&] { read_csv({folder_.path("")}); }, "found a directory; expected a file");
  expect_error([] { read_csv({}); }, "found no files");
  expect_error([&] { read("time,x,y\n0,1,2\n1,0,0\n", 0); }, "stride: found 0; expected >= 1");
}

}  // namespace
}  // namespace s2nnds
