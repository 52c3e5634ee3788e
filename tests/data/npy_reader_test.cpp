// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <zip.h>

#include <cstring>

#include "s2nnds/data/numpy_file.h"
#include "s2nnds/data/readers.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

// The bytes of an .npy file as numpy.save writes it.
std::string npy_bytes(const std::string& type, const std::string& shape, const std::string& data,
                      bool fortran = false) {
  std::string header = "{'descr': '" + type + "', 'fortran_order': " + (fortran ? "True" : "False") +
                       ", 'shape': (" + shape + "), }";
  header.resize((header.size() + 10 + 64) / 64 * 64 - 11, ' ');
  header += '\n';
  std::string bytes = "\x93NUMPY";
  bytes += std::string("\x01\x00", 2);
  bytes += static_cast<char>(header.size() % 256);
  bytes += static_cast<char>(header.size() / 256);
  return bytes + header + data;
}

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::string doubles(const std::string& shape, const std::vector<double>& values) {
  return npy_bytes("<f8", shape, bytes_of(values));
}

TEST(Npy, ReadsTypesAndOrders) {
  const std::vector<double> values = {1, 2.5, -3, 4, 5, 6};
  EXPECT_EQ(parse_npy(doubles("2, 3", values), "a").values, values);
  EXPECT_EQ(parse_npy(doubles("2, 3", values), "a").shape, (std::vector<Eigen::Index>{2, 3}));
  EXPECT_EQ(parse_npy(doubles("6,", values), "a").shape, (std::vector<Eigen::Index>{6}));
  EXPECT_EQ(parse_npy(npy_bytes("<f4", "6,", bytes_of<float>({1, 2.5F, -3, 4, 5, 6})), "a").values, values);
  EXPECT_EQ(parse_npy(npy_bytes("<f8", "2, 3", bytes_of<double>({1, 4, 2.5, 5, -3, 6}), true), "a").values,
            values);
  EXPECT_EQ(parse_npy(npy_bytes("<i8", "2,", bytes_of<std::int64_t>({-7, 1 << 30})), "a").values,
            (std::vector<double>{-7, 1 << 30}));
  EXPECT_EQ(parse_npy(npy_bytes(">i2", "2,", std::string("\x01\x00\xff\xff", 4)), "a").values,
            (std::vector<double>{256, -1}));
}

TEST(Npy, WhateverIsMissingIsAnError) {
  const std::string whole = doubles("2, 3", {1, 2, 3, 4, 5, 6});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THROW(parse_npy(whole.substr(0, size), "cut.npy"), Error) << size;
  }
  EXPECT_THROW(parse_npy(whole + "x", "long.npy"), Error);
  expect_error([&] { parse_npy(whole.substr(0, whole.size() - 8), "cut.npy"); },
               "cut.npy: found 40 bytes for shape [2, 3] of 8 bytes each; expected a whole .npy file");
  expect_error([] { parse_npy("time,x,y\n0,1,2\n", "text.npy"); }, "text.npy: found no .npy file");
  expect_error([] { parse_npy(npy_bytes("|O", "2,", "xx"), "a.npy"); }, "a.npy: found numbers of type '|O'");
  expect_error([] { parse_npy(npy_bytes("\x1b\n", "2,", "xx"), "a.npy"); },
               "found numbers of type '?\?'; expected");
  std::string axes;
  for (int i = 0; i < 65; ++i) axes += "1, ";
  expect_error([&] { parse_npy(doubles(axes, {1}), "a.npy"); }, "a.npy: found a shape of more than 64 axes");
  expect_error([] { parse_npy(npy_bytes("<c16", "2,", "xx"), "a.npy"); }, "found numbers of type '<c16'");
  expect_error([] { parse_npy(doubles("99999999999999, 99999999999", {1}), "a.npy"); }, "found shape [");
}

class NpyDemonstrations : public testing::Test {
 protected:
  // An .npz file of these entries.
  std::string archive(const std::vector<std::pair<std::string, std::string>>& entries) const {
    const std::string path = folder_.path("made.npz");
    int code = 0;
    zip_t* const zip = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
    for (const auto& [name, bytes] : entries)
      zip_file_add(zip, (name + ".npy").c_str(), zip_source_buffer(zip, bytes.data(), bytes.size(), 0), 0);
    zip_close(zip);
    return path;
  }

  TemporaryFolder folder_;
};

TEST_F(NpyDemonstrations, ATableOrSeveral) {
  const std::string one = folder_.write("one.npy", doubles("2, 3", {0, 1, 2, 0.5, 3, 5}));
  EXPECT_EQ(read_npy({one}).recordings.at(0).time, Vector({{0, 0.5}}));
  EXPECT_EQ(read_npy({one}).recordings.at(0).position, Points({{1, 2}, {3, 5}}));
  TableOptions options;
  options.columns.time = "2";
  options.columns.position = {"1", "0"};
  EXPECT_EQ(read_npy({one}, options).recordings.at(0).position, Points({{1, 0}, {3, 0.5}}));
  const std::string many = folder_.write("many.npy", doubles("2, 2, 2", {1, 2, 3, 4, 5, 6, 7, 8}));
  TableOptions counted;
  counted.rate = 2;
  const RecordingSet set = read_npy({many}, counted);
  ASSERT_EQ(set.recordings.size(), 2U);
  EXPECT_EQ(set.recordings[1].position, Points({{5, 6}, {7, 8}}));
  EXPECT_EQ(set.recordings[1].time, Vector({{0, 0.5}}));
  expect_error(
      [&] {
        read_npy({folder_.write("flat.npy", doubles("2,", {1, 2}))});
      },
      "flat.npy: found shape [2]");
  expect_error(
      [&] {
        read_npy({one, folder_.write("b.npy", doubles("2, 4", {0, 1, 2, 3, 1, 3, 5, 4}))});
      },
      "b.npy: found 3 position columns; expected 2");
}

TEST_F(NpyDemonstrations, NamedArrays) {
  const std::string time = doubles("2,", {0, 0.5}), position = doubles("2, 2", {1, 2, 3, 5});
  const std::string path =
      archive({{"t", time}, {"position", position}, {"vel", doubles("2, 2", {4, 4, 4, 4})}});
  const Recording r = read_npy({path}).recordings.at(0);
  EXPECT_EQ(r.time, Vector({{0, 0.5}}));
  EXPECT_EQ(r.position, Points({{1, 2}, {3, 5}}));
  EXPECT_EQ(r.velocity, Points::Constant(2, 2, 4));
  expect_error(
      [&] {
        read_npy({archive({{"t", time}, {"ee", position}})});
      },
      "made.npz: found the arrays 't', 'ee'; expected 'position' (data.columns.position names another)");
  TableOptions options;
  options.columns.position = {"ee"};
  EXPECT_EQ(read_npy({archive({{"t", time}, {"ee", position}})}, options).recordings.at(0).position,
            r.position);
  expect_error(
      [&] {
        read_npy({archive({{"t", doubles("3,", {0, 1, 2})}, {"position", position}})});
      },
      "found times of shape [3] for positions [2, 2]");
}

TEST_F(NpyDemonstrations, ATruncatedOrDamagedArchiveIsAnError) {
  std::vector<double> many(2000);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = std::sin(static_cast<double>(i));
  const std::string time = doubles("2,", {0, 0.5}), position = doubles("1000, 2", many);
  const std::string path = archive({{"time", time}, {"position", position}});
  const std::uintmax_t size = std::filesystem::file_size(path);
  std::filesystem::resize_file(path, size / 2);
  expect_error([&] { read_npy({path}); }, "made.npz: found no whole .npz file");
  const std::string damaged = archive({{"time", time}, {"position", position}});
  std::fstream file(damaged, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(size / 2));
  file.write("damaged!", 8);
  file.close();
  expect_error([&] { read_npy({damaged}); }, "made.npz: position: found damaged or truncated data");
  expect_error([&] { read_npy({folder_.write("text.npz", "time,x,y\n")}); },
               "text.npz: found no whole .npz file");
}

}  // namespace
}  // namespace s2nnds
