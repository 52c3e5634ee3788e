// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstring>

#include "region_attack.h"
#include "s2nnds/core/check.h"
#include "s2nnds/problem/mesh_file.h"
#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/problem/simplex_set.h"
#include "s2nnds/problem/triangle_distance.h"

namespace s2nnds {
namespace {

// A prism over an L, from z = 0 to 1: vertices [12, 3], triangles outwards.
const Points kL{{0.0, 0.0}, {1.0, 0.0}, {1.0, 0.4}, {0.4, 0.4}, {0.4, 1.0}, {0.0, 1.0}};

TriangleMesh prism() {
  TriangleMesh mesh{Points(12, 3), Eigen::MatrixXi(20, 3)};
  for (int k = 0; k < 6; ++k) {
    mesh.vertices.row(k) << kL(k, 0), kL(k, 1), 0.0;
    mesh.vertices.row(6 + k) << kL(k, 0), kL(k, 1), 1.0;
  }
  const int top[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}};
  int row = 0;
  for (const auto& t : top) {
    mesh.triangles.row(row++) << t[0] + 6, t[1] + 6, t[2] + 6;
    mesh.triangles.row(row++) << t[2], t[1], t[0];
  }
  for (int k = 0; k < 6; ++k) {
    const int next = (k + 1) % 6;
    mesh.triangles.row(row++) << k, next, next + 6;
    mesh.triangles.row(row++) << k, next + 6, k + 6;
  }
  return mesh;
}

double prism_distance(const Vector& x) {
  const double aside = polygon_distance(kL, x.head(2)), along = std::max(-x[2], x[2] - 1.0);
  return std::hypot(std::max(aside, 0.0), std::max(along, 0.0)) + std::min(0.0, std::max(aside, along));
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh both{Points(a.vertices.rows() + b.vertices.rows(), 3),
                    Eigen::MatrixXi(a.triangles.rows() + b.triangles.rows(), 3)};
  both.vertices << a.vertices, b.vertices;
  both.triangles << a.triangles, (b.triangles.array() + static_cast<int>(a.vertices.rows())).matrix();
  return both;
}

TriangleMesh turned_inwards(TriangleMesh mesh) {
  mesh.triangles.col(0).swap(mesh.triangles.col(1));
  return mesh;
}

std::string as_stl_text(const TriangleMesh& mesh) {
  std::string text = "solid made for a test\n";
  for (Eigen::Index k = 0; k < mesh.triangles.rows(); ++k) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (int i = 0; i < 3; ++i) {
      const auto v = mesh.vertices.row(mesh.triangles(k, i));
      text += fmt::format("   vertex {} {} {}\n", v[0], v[1], v[2]);
    }
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid\n";
}

std::string as_stl_binary(const TriangleMesh& mesh) {
  std::string bytes(80, 's');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.rows());
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (Eigen::Index k = 0; k < mesh.triangles.rows(); ++k) {
    bytes.append(12, '\0');
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const auto x = static_cast<float>(mesh.vertices(mesh.triangles(k, i), j));
        bytes.append(reinterpret_cast<const char*>(&x), 4);
      }
    }
    bytes.append(2, '\0');
  }
  return bytes;
}

std::string as_obj(const TriangleMesh& mesh) {
  std::string text = "# a comment\n";
  for (const auto& v : mesh.vertices.rowwise()) text += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
  for (const auto& t : mesh.triangles.rowwise())
    text += fmt::format("f {}/1 {}//2 {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

const Box kAround{Vector{{-0.5, -0.5, -0.5}}, Vector{{1.5, 1.5, 1.5}}};

TEST(Solid, SoundAndTight) { attack(solid(prism(), "prism"), kAround, prism_distance, 3000); }

TEST(Solid, DecidesBoxesThatRaysWouldPassThroughEdges) {
  // Centres in line with vertices, edges and diagonals along every axis.
  const RegionPtr region = solid(prism(), "prism");
  for (const double a : {-0.2, 0.0, 0.2, 0.4, 0.5, 1.0, 1.2}) {
    for (const double b : {-0.2, 0.0, 0.2, 0.4, 0.5, 1.0, 1.2}) {
      for (const double c : {-0.2, 0.0, 0.2, 0.5, 1.0, 1.2}) {
        const Vector x{{a, b, c}};
        const double exact = prism_distance(x);
        if (std::abs(exact) < 1e-9) continue;
        EXPECT_EQ(region->classify({x, x}), exact < 0.0 ? Location::inside : Location::outside)
            << x.transpose();
      }
    }
  }
}

TEST(Solid, BoxesBesideAFaceAreDecidedHoweverNear) {
  const RegionPtr region = solid(prism(), "prism");
  EXPECT_EQ(region->classify({Vector{{0.1, 0.1, 1.0 + 1e-9}}, Vector{{0.9, 0.9, 1.8}}}), Location::outside);
  EXPECT_EQ(region->classify({Vector{{1e-9, 1e-9, 1e-9}}, Vector{{0.3, 0.3, 1.0 - 1e-9}}}), Location::inside);
  EXPECT_EQ(region->classify({Vector{{0.1, 0.1, 0.9}}, Vector{{0.2, 0.2, 1.0 + 1e-9}}}), Location::unknown);
}

TEST(Solid, ShellsOverlapAndHollowsAreEmpty) {
  TriangleMesh moved = prism();
  moved.vertices.rowwise() += Eigen::RowVector3d(0.2, 0.1, 0.3);
  const RegionPtr both = solid(joined(prism(), moved), "both");
  EXPECT_EQ(both->classify({Vector{{0.25, 0.2, 0.5}}, Vector{{0.3, 0.25, 0.55}}}), Location::inside);
  EXPECT_EQ(both->classify({Vector{{0.05, 0.05, 0.1}}, Vector{{0.1, 0.06, 0.2}}}), Location::inside);
  EXPECT_EQ(both->classify({Vector{{0.25, 0.2, 1.1}}, Vector{{0.3, 0.25, 1.2}}}), Location::inside);
  TriangleMesh small = prism();
  small.vertices = 0.2 * small.vertices;
  small.vertices.rowwise() += Eigen::RowVector3d(0.1, 0.1, 0.1);
  const RegionPtr hollow = solid(joined(prism(), turned_inwards(small)), "hollow");
  EXPECT_EQ(hollow->classify({Vector{{0.12, 0.12, 0.12}}, Vector{{0.13, 0.13, 0.2}}}), Location::outside);
  EXPECT_EQ(hollow->classify({Vector{{0.02, 0.02, 0.02}}, Vector{{0.05, 0.05, 0.05}}}), Location::inside);
  EXPECT_LT(solid(turned_inwards(prism()), "inside out")->level(Points{{0.2, 0.2, 0.5}})[0], 0.0);
}

TEST(Solid, FilesOfEachFormatSayTheSame) {
  const auto made = [](const std::string& name, const std::string& bytes, const std::string& keys = "") {
    return region_of(fmt::format("type = \"mesh\"\nfile = \"{}\"\n{}", name, keys), 3,
                     RegionFiles(std::map<std::string, std::string>{{name, bytes}}));
  };
  TriangleMesh coarse = prism();
  coarse.vertices = (coarse.vertices * 1024.0).array().round() / 1024.0;  // exact as floats
  const Points x{{0.1, 0.2, 0.3}, {1.1, 0.9, 1.2}, {0.7, 0.7, 0.5}};
  const Vector level = solid(coarse, "")->level(x);
  for (const auto& region : {made("a.stl", as_stl_text(coarse)), made("a.STL", as_stl_binary(coarse)),
                             made("b/a.obj", as_obj(coarse))}) {
    EXPECT_LE((region->level(x) - level).cwiseAbs().maxCoeff(), 0.0) << region->describe();
  }
  // In mm, turned by 90 degrees about z and moved.
  TriangleMesh in_mm = coarse;
  in_mm.vertices *= 1000.0;
  const RegionPtr placed =
      made("mm.obj", as_obj(in_mm), "scale = 0.001\nrotation = [0, 0, 1, 1]\ncenter = [2, 0, 0]");
  EXPECT_NEAR(placed->level(Points{{2.0 - 0.2, 0.1, 0.3}})[0], level[0], 1e-12);
  EXPECT_EQ(placed->describe(), "mesh mm.obj (20 triangles) scale 0.001 rotation (0, 0, 1, 1) at (2, 0, 0)");
  // A square face, counted from the end.
  const std::string cube =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
      "f 4 3 2 1\nf -4 -3 -2 -1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  EXPECT_NEAR(made("cube.obj", cube)->level(Points{{0.5, 0.5, 0.25}})[0], -0.25, 1e-15);
}

TEST(Solid, BadFilesAreNamed) {
  const auto made = [](const std::string& name, const std::string& bytes) {
    return message_of([&] {
      region_of("type = \"mesh\"\nfile = \"" + name + "\"", 3,
                RegionFiles(std::map<std::string, std::string>{{name, bytes}}));
    });
  };
  const std::string text = as_stl_text(prism()), binary = as_stl_binary(prism()), obj = as_obj(prism());
  for (const std::size_t cut : {40u, 200u, 900u}) {
    EXPECT_NE(made("a.stl", text.substr(0, cut)), "") << cut;
    EXPECT_NE(made("a.stl", binary.substr(0, cut)), "") << cut;
  }
  expect_message(made("a.stl", binary.substr(0, 900)), "expected 1084 of the 20 triangles");
  expect_message(made("a.stl", text.substr(0, text.size() / 2)), "expected 'endsolid'");
  expect_message(made("a.obj", obj.substr(0, obj.rfind("f "))), "edges are open, the first from");
  expect_message(made("a.obj", "v 0 0\n"), "a.obj:1: found a vertex of 2 numbers");
  expect_message(made("a.obj", "v 0 0 nan\n"), "expected a finite number");
  // What is not a number must not pass for another vertex.
  std::string damaged = binary;
  const float none = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(&damaged[84 + 50 * 7 + 12], &none, sizeof none);
  expect_message(made("a.stl", damaged), "a.stl: found the vertex (nan, ");
  expect_message(made("a.obj", "v 0 0 0\nf 1 2 3\n"), "found vertex 2");
  expect_message(made("a.obj", "v 0 0 0\n"), "no triangles");
  expect_message(made("a.step", "v 0 0 0\n"), ".stl or .obj");
  TriangleMesh one_turned = prism();
  std::swap(one_turned.triangles(3, 0), one_turned.triangles(3, 1));
  expect_message(made("a.obj", as_obj(one_turned)), "turn opposite ways");
  TriangleMesh flat = prism();
  flat.vertices.col(2).setZero();
  expect_message(made("a.obj", as_obj(flat)), "expected a solid");
  expect_message(message_of([] { region_of("type = \"mesh\"\nfile = \"none.stl\"", 3); }),
                 "cannot read none.stl");
  expect_message(message_of([] { region_of("type = \"mesh\"", 3); }), "expected the key file");
  expect_message(message_of([] { region_of("type = \"mesh\"\nfile = \"a.stl\"", 2); }), "expected 3");
}

TEST(Solid, ManyTrianglesAreQuick) {
  // A sphere of 20,000 triangles: its level is that of the ball to within the triangles' sag.
  const int rings = 100, sectors = 100;
  TriangleMesh mesh{Points(rings * sectors + 2, 3), Eigen::MatrixXi(2 * rings * sectors, 3)};
  for (int r = 0; r < rings; ++r) {
    for (int s = 0; s < sectors; ++s) {
      const double polar = M_PI * (r + 1) / (rings + 1), around = 2 * M_PI * s / sectors;
      mesh.vertices.row(r * sectors + s) << std::sin(polar) * std::cos(around),
          std::sin(polar) * std::sin(around), std::cos(polar);
    }
  }
  mesh.vertices.row(rings * sectors) << 0, 0, 1;
  mesh.vertices.row(rings * sectors + 1) << 0, 0, -1;
  int row = 0;
  for (int s = 0; s < sectors; ++s) {
    const int t = (s + 1) % sectors;
    mesh.triangles.row(row++) << rings * sectors, s, t;
    mesh.triangles.row(row++) << rings * sectors + 1, (rings - 1) * sectors + t, (rings - 1) * sectors + s;
    for (int r = 0; r + 1 < rings; ++r) {
      mesh.triangles.row(row++) << r * sectors + s, (r + 1) * sectors + s, (r + 1) * sectors + t;
      mesh.triangles.row(row++) << r * sectors + s, (r + 1) * sectors + t, r * sectors + t;
    }
  }
  mesh.triangles.conservativeResize(row, 3);
  const RegionPtr sphere = solid(mesh, "sphere");
  RandomStream random(2, "sphere");
  for (int k = 0; k < 3000; ++k) {
    const Box box = random_box(random, Box::cube(3, 1.2), 0.3);
    const double level = box.center().norm() - 1.0;
    EXPECT_NEAR(sphere->level(box.center().transpose())[0], level, 2e-3);
    if (std::abs(level) > 1.02 * half_diagonal(box) + 2e-3) {
      EXPECT_EQ(sphere->classify(box), level > 0.0 ? Location::outside : Location::inside);
    }
  }
}

// A sphere of 20 x 40 patches about (0.1, 0.2, 0.3).
TriangleMesh round_mesh() {
  constexpr int kRings = 20, kColumns = 40;
  TriangleMesh mesh{Points((kRings - 1) * kColumns + 2, 3), Eigen::MatrixXi(2 * kColumns * (kRings - 1), 3)};
  const int top = (kRings - 1) * kColumns, bottom = top + 1;
  for (int i = 1; i < kRings; ++i) {
    for (int j = 0; j < kColumns; ++j) {
      const double a = M_PI * i / kRings, b = 2 * M_PI * j / kColumns;
      mesh.vertices.row((i - 1) * kColumns + j) << std::sin(a) * std::cos(b), std::sin(a) * std::sin(b),
          std::cos(a);
    }
  }
  mesh.vertices.row(top) << 0, 0, 1;
  mesh.vertices.row(bottom) << 0, 0, -1;
  int k = 0;
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < kColumns; ++j) {
      const auto at = [&](int ring, int column) {
        return ring == 0 ? top : ring == kRings ? bottom : (ring - 1) * kColumns + column % kColumns;
      };
      if (i > 0) mesh.triangles.row(k++) << at(i, j), at(i + 1, j), at(i, j + 1);
      if (i + 1 < kRings) mesh.triangles.row(k++) << at(i, j + 1), at(i + 1, j), at(i + 1, j + 1);
    }
  }
  mesh.vertices = (0.4 * mesh.vertices).rowwise() + Eigen::RowVector3d(0.1, 0.2, 0.3);
  return mesh;
}

TEST(Solid, LevelIsTheDistanceAndTheSideOfEnclosures) {
  const TriangleMesh mesh = round_mesh();
  const SimplexSet surface(mesh.vertices, mesh.triangles);
  const RegionPtr region = solid(mesh, "ball");
  RandomStream random(5, "levels");
  const Points x = uniform_points(Box::cube(3, 1.0), 4000, random);
  const Vector level = region->level(x);
  int inside = 0;
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    const Interval distance = surface.distance(x.row(k).transpose());
    EXPECT_NEAR(std::abs(level[k]), distance.upper, 1e-12);
    const double from_center = (x.row(k) - Eigen::RowVector3d(0.1, 0.2, 0.3)).norm();
    if (from_center > 0.4) {
      EXPECT_GT(level[k], 0);
    }
    if (from_center < 0.39) {
      EXPECT_LT(level[k], 0);
      ++inside;
    }
    const Box point{x.row(k).transpose(), x.row(k).transpose()};
    const Interval exact = region->enclosure(point);
    EXPECT_LE(exact.lower, level[k] + 1e-12);
    EXPECT_GE(exact.upper, level[k] - 1e-12);
  }
  EXPECT_GT(inside, 50);
}

TEST(TriangleDistance, IsThatOfTheNearestPointAlsoOfTrianglesWithoutArea) {
  RandomStream random(6, "triangles");
  for (int k = 0; k < 300; ++k) {
    Points corners = uniform_points(Box::cube(3, 1.0), 3, random);
    if (k % 3 == 1) corners.row(2) = 0.5 * (corners.row(0) + corners.row(1));
    if (k % 3 == 2) corners.row(2) = corners.row(0);
    Eigen::MatrixXi triangle(1, 3);
    triangle << 0, 1, 2;
    const TriangleDistance distance(corners, triangle);
    const SimplexSet exact(corners, triangle);
    const Points x = uniform_points(Box::cube(3, 2.0), 20, random);
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      const Interval bounds = exact.distance(x.row(i).transpose());
      EXPECT_LE(distance(x.row(i).transpose()), bounds.upper + 1e-9);
      EXPECT_GE(distance(x.row(i).transpose()), bounds.lower - 1e-9);
    }
  }
}

}  // namespace
}  // namespace s2nnds
