// SPDX-License-Identifier: BSD-3-Clause
// Regions from what sensors record: point clouds and occupancy maps.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "region_attack.h"
#include "s2nnds/core/check.h"
#include "s2nnds/problem/occupancy_region.h"
#include "s2nnds/problem/point_cloud_file.h"
#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

using Stored = std::map<std::string, std::string>;

RegionPtr cloud_of(const std::string& name, const std::string& bytes, Eigen::Index dimension,
                   const std::string& keys = "radius = 0.1") {
  return region_of(fmt::format("type = \"point_cloud\"\nfile = \"{}\"\n{}", name, keys), dimension,
                   RegionFiles(Stored{{name, bytes}}));
}

std::string raw(const std::vector<float>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), 4 * numbers.size()};
}

std::string npy(const std::string& shape, const std::string& type, const std::string& numbers) {
  std::string head = "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }";
  head.resize(118, ' ');
  return std::string("\x93NUMPY\x01\x00\x76\x00", 10) + head + numbers;
}

TEST(PointCloud, SoundAndTight) {
  for (const Eigen::Index n : {2, 3}) {
    RandomStream random(11, "cloud");
    const Points points = uniform_points(Box::cube(n, 0.5), 300, random);
    std::string text;
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      for (Eigen::Index i = 0; i < n; ++i) text += fmt::format("{}{}", i > 0 ? "," : "", points(k, i));
      text += "\n";
    }
    attack(
        cloud_of("a.csv", text, n), Box::cube(n, 1.0),
        [&](const Vector& x) { return (points.rowwise() - x.transpose()).rowwise().norm().minCoeff() - 0.1; },
        2000);
  }
}

TEST(PointCloud, FilesOfEachFormatSayTheSame) {
  const Points expected{{0.5, -1.0, 2.0}, {0.25, 0.0, 3.0}};
  const std::string numbers = raw({0.5f, -1.0f, 2.0f, 0.25f, 0.0f, 3.0f});
  const std::string ply_head =
      "ply\nformat {} 1.0\ncomment made for a test\nelement vertex 2\nproperty float x\n"
      "property float y\nproperty float z\nelement face 0\n"
      "property list uchar int vertex_indices\nend_header\n";
  const std::string pcd_head =
      "# .PCD v.7\nVERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\n"
      "HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA {}\n";
  const std::string text = "0.5 -1 2\n0.25 0 3\n";
  const Stored files{{"a.csv", "0.5,-1,2\r\n0.25,0,3\r\n"},
                     {"b.csv", "time;z;x;y\n0;2;0.5;-1\n1;3;+0.25;0\n"},
                     {"a.xyz", "# x y z\n" + text},
                     {"a.ply", fmt::format(fmt::runtime(ply_head), "ascii") + text},
                     {"b.ply", fmt::format(fmt::runtime(ply_head), "binary_little_endian") + numbers},
                     {"a.pcd", fmt::format(fmt::runtime(pcd_head), "ascii") + text},
                     {"b.pcd", fmt::format(fmt::runtime(pcd_head), "binary") + numbers},
                     {"a.npy", npy("(2, 3)", "<f4", numbers)}};
  for (const auto& [name, bytes] : files) {
    const Points found = read_point_cloud(bytes, name, 3);
    ASSERT_EQ(found.rows(), 2) << name;
    EXPECT_EQ(found, expected) << name;
  }
  EXPECT_EQ(cloud_of("b.csv", files.at("b.csv"), 3)->describe(), "points of b.csv (2) radius 0.1");
  // In mm and turned.
  const RegionPtr placed = cloud_of(
      "a.csv", "1000,0\n", 2, "radius = 0.1\nscale = 0.001\nangle = 1.5707963267948966\ncenter = [0, 1]");
  EXPECT_NEAR(placed->level(Points{{0.0, 2.0}})[0], -0.1, 1e-15);
  // Rays without an echo.
  EXPECT_EQ(
      read_point_cloud(fmt::format(fmt::runtime(pcd_head), "ascii") + "nan nan nan\n1 2 3\n", "a.pcd", 3),
      (Points{{1.0, 2.0, 3.0}}));
  // A planar scan kept in space.
  EXPECT_EQ(read_point_cloud("1 2 0.3\n3 4 0.3\n", "a.xyz", 2), (Points{{1.0, 2.0}, {3.0, 4.0}}));
}

TEST(PointCloud, BadFilesAreNamed) {
  const auto made = [](const std::string& name, const std::string& bytes, int n = 2) {
    return message_of([&] { cloud_of(name, bytes, n); });
  };
  expect_message(made("a.csv", "1,2\n3\n"), "point 1 has 1 coordinates");
  expect_message(made("a.csv", "1,2\n3,nan\n"), "a.csv:2: found 'nan'");
  expect_message(made("a.csv", "1,2\n3,inf\n"), "a.csv:2: found 'inf'");
  expect_message(made("a.csv", "1,2\n3,cat\n"), "'cat'");
  expect_message(made("a.csv", "a,b\n3,4\n"), "found the columns a, b");
  expect_message(made("a.csv", "1,2\n3,\x1b[2Jcat\n"), "found '?[2Jcat', expected");
  expect_message(made("a.csv", "a\x07," + std::string(500, 'b') + "\n3,4\n"), "found the columns a?, bbb");
  expect_message(made("a.csv", "x,y\n"), "no points");
  expect_message(made("a.csv", "1,2,3\n1,2,4\n"), "expected one height");
  expect_message(made("a.csv", "1,2,3,4\n"), "points of 4 coordinates, expected 2");
  expect_message(made("a.las", "1,2\n"), "with the ending");
  expect_message(made("a.ply", "plx\n"), "expected PLY");
  expect_message(
      made("a.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"),
      "end_header");
  const std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float "
      "y\nend_header\n";
  expect_message(made("a.ply", ply + raw({1.0f, 2.0f, 3.0f})), "found 12 bytes of points");
  expect_message(made("a.ply", ply + raw({1.0f, 2.0f, 3.0f, std::nanf("")})), "point 1 is not a finite");
  expect_message(made("a.pcd", "VERSION .7\nFIELDS x y\n"), "PCD head");
  expect_message(made("a.pcd", "FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 1\nDATA binary_compressed\n...."),
                 "binary_compressed");
  expect_message(
      made("a.pcd", "FIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 9999999999\nPOINTS 1\nDATA ascii\n1 2\n"),
      "found 9999999999 numbers a point in the field y");
  expect_message(made("a.pcd", "FIELDS x y\nSIZE 4 4\nTYPE F X\nPOINTS 1\nDATA ascii\n1 2\n"),
                 "types I, U or F");
  expect_message(made("a.npy", "NUMPY"), "expected NPY");
  expect_message(made("a.npy", npy("(2, 2)", "<f8", raw({1.0f, 2.0f}))), "found 8 bytes of numbers");
  expect_message(made("a.npy", npy("(4,)", "<f4", raw({1.0f, 2.0f, 3.0f, 4.0f}))), "two indices");
  expect_message(made("a.npy", npy("(2, 2)", "<i4", raw({1.0f, 2.0f, 3.0f, 4.0f}))), "float32 or float64");
  expect_message(message_of([] { cloud_of("a.csv", "1,2\n", 2, ""); }), "radius");
}

// 6 x 4 cells of 0.25, the top row first: a wall, a block and an unknown corner.
const std::string kImage =
    "P2\n# a map\n6 4\n255\n"
    "0 0 0 0 0 0\n"
    "254 254 254 254 254 205\n"
    "254 0 0 254 254 254\n"
    "254 0 0 254 254 254\n";
const std::string kYaml =
    "image: map.pgm\nresolution: 0.25\norigin: [-0.5, 0.25, 0.0]\nnegate: 0\n"
    "occupied_thresh: 0.65\nfree_thresh: 0.196\n";

RegionPtr map_of(const std::string& yaml, const std::string& image, const std::string& keys = "") {
  return region_of("type = \"occupancy_image\"\nfile = \"maps/room.yaml\"\n" + keys, 2,
                   RegionFiles(Stored{{"maps/room.yaml", yaml}, {"maps/map.pgm", image}}));
}

// By every cell of the picture and of two more around it.
double map_distance(const Vector& x, bool unknown_is_occupied) {
  const char* rows[] = {"XXXXXX", ".....?", ".XX...", ".XX..."};
  double to_occupied = 1e300, to_free = 1e300;
  for (int i = -8; i < 14; ++i) {
    for (int j = -8; j < 12; ++j) {
      const char cell = i >= 0 && i < 6 && j >= 0 && j < 4 ? rows[3 - j][i] : '?';
      const bool occupied = cell == 'X' || (cell == '?' && unknown_is_occupied);
      const double left = -0.5 + 0.25 * i - x[0], low = 0.25 + 0.25 * j - x[1];
      const double d = std::hypot(std::max({left, -left - 0.25, 0.0}), std::max({low, -low - 0.25, 0.0}));
      (occupied ? to_occupied : to_free) = std::min(occupied ? to_occupied : to_free, d);
    }
  }
  return to_occupied > 0.0 ? to_occupied : -to_free;
}

TEST(OccupancyImage, SoundAndTight) {
  const Box around{Vector{{-1.0, -0.2}}, Vector{{1.4, 1.7}}};
  attack(
      map_of(kYaml, kImage), around, [](const Vector& x) { return map_distance(x, true); }, 4000);
  attack(
      map_of(kYaml, kImage, "unknown = \"free\""), around,
      [](const Vector& x) { return map_distance(x, false); }, 4000);
  EXPECT_EQ(map_of(kYaml, kImage)->describe(), "map maps/room.yaml, unknown cells occupied");
}

TEST(OccupancyImage, TurnedMaps) {
  std::string yaml = kYaml;
  yaml.replace(yaml.find("0.25, 0.0]"), 10, "0.25, 0.5]");
  const double c = std::cos(0.5), s = std::sin(0.5);
  attack(
      map_of(yaml, kImage, "unknown = \"free\""), {Vector{{-1.0, -0.2}}, Vector{{1.4, 1.7}}},
      [&](const Vector& x) {
        const double dx = x[0] + 0.5, dy = x[1] - 0.25;
        return map_distance(Vector{{-0.5 + c * dx + s * dy, 0.25 - s * dx + c * dy}}, false);
      },
      3000);
}

TEST(OccupancyImage, FormatsSayTheSame) {
  std::string binary = "P5 6 4 255\n";
  for (const char c : std::string("XXXXXX.....?.XX....XX..."))
    binary += c == 'X' ? '\0' : c == '.' ? '\xfe' : '\xcd';
  std::string negated = "P2 6 4 255 ";
  for (const char c : std::string("XXXXXX.....?.XX....XX..."))
    negated += c == 'X' ? "255 " : c == '.' ? "1 " : "50 ";
  std::string negated_yaml = kYaml, blocks = kYaml;
  negated_yaml.replace(negated_yaml.find("negate: 0"), 9, "negate: 1");
  blocks.replace(blocks.find("[-0.5, 0.25, 0.0]"), 17, "\n- -0.5\n- 0.25\n- 0.0");
  RandomStream random(1, "map");
  const Points x = uniform_points({Vector{{-1.0, -0.2}}, Vector{{1.4, 1.7}}}, 500, random);
  const Vector level = map_of(kYaml, kImage)->level(x);
  EXPECT_EQ(map_of(kYaml, binary)->level(x), level);
  EXPECT_EQ(map_of(negated_yaml, negated)->level(x), level);
  EXPECT_EQ(map_of(blocks, kImage)->level(x), level);
}

TEST(OccupancyImage, BadFilesAreNamed) {
  const auto made = [](const std::string& yaml, const std::string& image) {
    return message_of([&] { map_of(yaml, image); });
  };
  const auto with = [](const std::string& from, const std::string& to) {
    std::string yaml = kYaml;
    return yaml.replace(yaml.find(from), from.size(), to);
  };
  expect_message(made(kYaml, kImage.substr(0, 60)), "map.pgm: ends");
  expect_message(made(kYaml, "P5 6 4 255\nabc"), "found 3 bytes of pixels, expected 6 x 4");
  expect_message(made(kYaml, "P6 6 4 255\n"), "begins with P2 or P5");
  expect_message(made(kYaml, "P2 1 1 255 300"), "found the value 300");
  expect_message(made(kYaml, "P5 2 1 65535\nabcd"), "8 bits");
  expect_message(made(kYaml, "P5 2 1 99\nzz"), "found the value 122, expected at most 99");
  expect_message(message_of([] { map_of(kYaml, "P2 2 1 255 254 254", "unknown = \"free\""); }),
                 "no occupied cells");
  EXPECT_TRUE(map_of(kYaml, "P2 2 1 255 254 254")->contains(Vector{{-1.0, 0.0}}));  // beyond the map
  expect_message(made(kYaml, "P2 2 1 255 0 0"), "no free cells");
  expect_message(made(with("resolution: 0.25", ""), kImage), "one value of the key resolution");
  expect_message(made(with("resolution: 0.25", "resolution: -1"), kImage), "expected > 0");
  expect_message(made(with("resolution: 0.25", "resolution: nan"), kImage), "finite number");
  expect_message(made(with("[-0.5, 0.25, 0.0]", "[0, 0]"), kImage), "3 numbers of the key origin");
  expect_message(made(with("negate: 0", "negate: 2"), kImage), "expected 0 or 1");
  expect_message(made(with("negate: 0", "negate: 0\nmode: raw"), kImage), "mode raw");
  expect_message(made(with("free_thresh: 0.196", "free_thresh: 0.9"), kImage),
                 "free_thresh < occupied_thresh");
  expect_message(made(with("image: map.pgm", "image: other.pgm"), kImage), "file maps/other.pgm");
}

TEST(RegionFiles, AreReadOnceKeptAndCompared) {
  const std::string folder = testing::TempDir();
  const std::string path = folder + "/region_files_test.csv";
  const auto put = [&](const std::string& text) {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    std::fwrite(text.data(), 1, text.size(), file);
    std::fclose(file);
  };
  put("0.5,0.5\n");
  RegionFiles files(folder);
  const RegionOptions options{.type = "point_cloud", .radius = 0.1, .file = "region_files_test.csv"};
  const RegionPtr region = make_region(options, 2, files, "region");
  EXPECT_TRUE(files.changed_in(folder).empty());
  put("0.7,0.7\n");
  EXPECT_EQ(files.changed_in(folder), std::vector<std::string>{"region_files_test.csv"});
  RegionFiles stored(files.all());
  std::remove(path.c_str());
  EXPECT_TRUE(files.changed_in(folder).empty());  // nothing to compare with
  EXPECT_TRUE(make_region(options, 2, stored, "region")->contains(Vector{{0.5, 0.5}}));
  expect_message(message_of([&] { stored.bytes("other"); }), "the run does not have it");
  expect_message(message_of([&] { RegionFiles(folder).bytes("none.csv"); }), "cannot read");
  expect_message(message_of([&] { RegionFiles(folder).bytes("."); }), "found a folder");
  // As large as a run keeps, and one byte more. The file takes no room on the disk.
  constexpr std::size_t most = 64'000'000;
  put("x");
  std::filesystem::resize_file(path, most);
  EXPECT_EQ(RegionFiles(folder).bytes("region_files_test.csv").size(), most);
  std::filesystem::resize_file(path, most + 1);
  expect_message(message_of([&] { RegionFiles(folder).bytes("region_files_test.csv"); }), "more than 64 MB");
  std::remove(path.c_str());
}

}  // namespace
}  // namespace s2nnds
