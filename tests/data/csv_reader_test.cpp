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
    return read_csv({folder_.write("one.csv", text)}, stride).demonstrations.at(0);
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
  const DemonstrationSet set = read_csv({a, b});
  EXPECT_EQ(set.name, "a");
  ASSERT_EQ(set.demonstrations.size(), 2U);
  EXPECT_EQ(set.demonstrations[1].samples(), 3);
  const std::string c = folder_.write("c.csv", "time,x,y,z\n0,1,2,3\n1,0,0,0\n");
  expect_error([&] { read_csv({a, c}); }, "c.csv: found 3 position columns; expected 2 as in ");
}

TEST_F(CsvReader, BadHeaders) {
  expect_rejected("0,1,2\n1,2,3\n", "one.csv:1: found first column '0'; expected the header time,x,y[,z]");
  expect_rejected("", "one.csv:1: found an empty file");
  expect_rejected("\n\ntime,x\n0,1\n", "one.csv:3: found 2 column(s)");
  expect_rejected("time,x,y,w\n", "one.csv:1: found column 'w' at place 4");
  expect_rejected("time,x,y,dx\n", "one.csv:1: found 4 column(s)");
  expect_rejected("time,x,y,dy,dx\n", "one.csv:1: found column 'dy' at place 4");
  expect_rejected("time,x,y,dx,dy,dz\n", "one.csv:1: found column 'dz' at place 6");
  expect_rejected(std::string("\x01\x02\0\x7f", 4), "found first column '?");
}

TEST_F(CsvReader, BadRowsAreNamedByFileAndLine) {
  const std::string head = "time,x,y\n0,1,2\n";
  expect_rejected(head + "1,2\n", "one.csv:3: found 2 values; expected 3");
  expect_rejected(head + "\n1,2,3,4\n", "one.csv:4: found 4 values; expected 3");
  expect_rejected(head + "1,nan,3\n", "one.csv:3: found 'nan'; expected a finite number");
  expect_rejected(head + "1,2,inf\n", "one.csv:3: found 'inf'");
  expect_rejected(head + "1,2,-Inf\n", "one.csv:3: found '-Inf'");
  expect_rejected(head + "1,2,1e999\n", "one.csv:3: found '1e999'");
  expect_rejected(head + "1,2,3 4\n", "one.csv:3: found '3 4'");
  expect_rejected(head + "1,2,0x10\n", "one.csv:3: found '0x10'");
  expect_rejected(head + "1,,3\n", "one.csv:3: found ''");
  expect_rejected(head + "1;2;3\n", "one.csv:3: found 1 values");
  expect_rejected(head + "0,2,3\n", "one.csv:3: found time 0 after 0; expected increasing times");
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
