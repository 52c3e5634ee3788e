// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "region_attack.h"
#include "s2nnds/core/check.h"
#include "s2nnds/problem/boundary_points.h"
#include "s2nnds/problem/placed_region.h"
#include "s2nnds/problem/polygon.h"
#include "s2nnds/problem/polytope.h"
#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/problem/tube.h"

namespace s2nnds {
namespace {

const Points kArrow{{-0.6, -0.5}, {0.7, -0.1}, {-0.5, 0.6}, {-0.2, 0.1}};  // not convex
const Points kHole{{0.0, -0.1}, {0.2, -0.1}, {0.1, 0.1}};

TEST(Polygon, KnownDistances) {
  const RegionPtr square = region_of("type = \"polygon\"\nvertices = [[0, 0], [1, 0], [1, 1], [0, 1]]", 2);
  const Vector level = square->level(Points{{0.5, 0.25}, {2.0, 0.5}, {2.0, 2.0}, {1.0, 0.5}, {0.5, 0.5}});
  EXPECT_NEAR(level[0], -0.25, 1e-15);
  EXPECT_NEAR(level[1], 1.0, 1e-15);
  EXPECT_NEAR(level[2], std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(level[3], 0.0, 1e-300);
  EXPECT_NEAR(level[4], -0.5, 1e-15);
  EXPECT_EQ(square->describe(), "polygon (0, 0) (1, 0) (1, 1) (0, 1)");
}

TEST(Polygon, SoundAndTightForBothDirectionsAndWithAHole) {
  const Box around = Box::cube(2, 1.0);
  attack(
      polygon(kArrow), around, [](const Vector& x) { return polygon_distance(kArrow, x); }, 4000);
  attack(
      polygon(kArrow.colwise().reverse()), around,
      [](const Vector& x) { return polygon_distance(kArrow, x); }, 1000);
  attack(
      polygon(kArrow, {kHole}), around,
      [](const Vector& x) { return std::max(polygon_distance(kArrow, x), -polygon_distance(kHole, x)); },
      4000);
}

TEST(Polygon, BoxesBesideAnEdgeAreDecidedHoweverNear) {
  const RegionPtr triangle = polygon(Points{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}});
  // Its corner nearest to the slanted edge is 1e-9 away, its centre far.
  const double near = 0.5 + 1e-9;
  EXPECT_EQ(triangle->classify({Vector{{near, near}}, Vector{{near + 1.0, near + 1.0}}}), Location::outside);
  EXPECT_EQ(triangle->classify({Vector{{0.1, 0.1}}, Vector{{0.5 - 1e-9, 0.5 - 1e-9}}}), Location::inside);
  EXPECT_EQ(triangle->classify({Vector{{0.3, -0.2}}, Vector{{0.4, -1e-12}}}), Location::outside);
  EXPECT_EQ(triangle->classify({Vector{{0.3, -0.2}}, Vector{{0.4, 1e-12}}}), Location::unknown);
}

TEST(Polygon, BadOnesAreNamed) {
  const auto made = [](const std::string& keys) {
    return message_of([&] { region_of("type = \"polygon\"\n" + keys, 2); });
  };
  expect_message(made("vertices = [[0, 0], [1, 0]]"), "2 corners");
  expect_message(made("vertices = [[0, 0], [1, 0, 3], [1, 1]]"), "vertices[1] has 3 numbers");
  expect_message(made("vertices = [0, 0]"), "vertices[0]: expected a list of numbers");
  expect_message(made("vertices = [[0, 0], [1, nan], [1, 1]]"), "vertices[1][1]");
  expect_message(made("vertices = [[0, 0], [1, inf], [1, 1]]"), "finite");
  expect_message(made("vertices = [[0, 0], [1, 1], [1, 0], [0, 1]]"), "neither cross nor touch");
  expect_message(made("vertices = [[0, 0], [1, 0], [1, 0], [0, 1]]"), "corners 1 and 2");
  expect_message(made("vertices = [[0, 0], [1, 0], [0.5, 0], [0.5, 1]]"), "neither cross nor touch");
  expect_message(made("vertices = [[0, 0], [2, 0], [1, 1], [1, 0], [1, 2]]"), "neither cross nor touch");
  const std::string square = "vertices = [[0, 0], [1, 0], [1, 1], [0, 1]]\n";
  expect_message(made(square + "holes = [{vertices = [[2, 2], [3, 2], [2, 3]]}]"), "hole 0 lies outside");
  const std::string outer = "{vertices = [[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]]}";
  const std::string inner = "{vertices = [[0.2, 0.2], [0.3, 0.2], [0.2, 0.3]]}";
  expect_message(made(square + "holes = [" + outer + ", " + inner + "]"), "hole 1 lies within hole 0");
  expect_message(made(square + "holes = [" + inner + ", " + outer + "]"), "hole 0 lies within hole 1");
  EXPECT_EQ(made(square + "holes = [" + inner + ", {vertices = [[0.5, 0.5], [0.6, 0.5], [0.5, 0.6]]}]"), "");
  expect_message(made(square + "holes = [{vertices = [[0.5, 0.5], [3, 2], [2, 3]]}]"), "neither cross");
  expect_message(made(square + "radius = 1"), "unknown key radius");
  expect_message(message_of([&] { region_of("type = \"polygon\"\n" + square, 3); }), "3 dimensions");
}

TEST(Polygon, OptionsComeBackFromText) {
  RegionOptions options{.type = "polygon",
                        .vertices = {{0.0, 0.0}, {0.1, 1e-17}, {0.3, 0.7}},
                        .holes = {{.vertices = {{0.1, 0.1}, {0.12, 0.1}, {0.12, 0.12}}}},
                        .inflate = 0.125},
      again;
  read_toml(to_toml(options), "again", again);
  EXPECT_EQ(again.vertices, options.vertices);
  ASSERT_EQ(again.holes.size(), 1u);
  EXPECT_EQ(again.holes[0].vertices, options.holes[0].vertices);
  EXPECT_EQ(again.inflate, 0.125);
}

TEST(OrientedBox, SoundAndTightInThePlane) {
  const double angle = 0.7, c = std::cos(angle), s = std::sin(angle);
  const RegionPtr box =
      region_of("type = \"oriented_box\"\ncenter = [0.2, -0.1]\nhalf_sizes = [0.6, 0.2]\nangle = 0.7", 2);
  Points corners(4, 2);
  corners << 0.2 + 0.6 * c - 0.2 * s, -0.1 + 0.6 * s + 0.2 * c, 0.2 - 0.6 * c - 0.2 * s,
      -0.1 - 0.6 * s + 0.2 * c, 0.2 - 0.6 * c + 0.2 * s, -0.1 - 0.6 * s - 0.2 * c, 0.2 + 0.6 * c + 0.2 * s,
      -0.1 + 0.6 * s - 0.2 * c;
  attack(
      box, Box::cube(2, 1.0), [&](const Vector& x) { return polygon_distance(corners, x); }, 4000);
  EXPECT_EQ(box->describe(), "box centre (0.2, -0.1) half sizes (0.6, 0.2) angle 0.7");
}

TEST(OrientedBox, SoundAndTightInSpace) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(0.8, 0.1, -0.4, 0.3).normalized();
  const Vector half{{0.5, 0.3, 0.2}}, center{{0.1, 0.0, -0.1}};
  const Reference exact = [&](const Vector& x) {
    const Eigen::Array3d e = (q.conjugate() * Eigen::Vector3d(x - center)).array().abs() - half.array();
    return e.max(0.0).matrix().norm() + std::min(0.0, e.maxCoeff());
  };
  const RegionPtr by_quaternion = oriented_box(center, half, rotation_in_space({0.1, -0.4, 0.3, 0.8}));
  attack(by_quaternion, Box::cube(3, 1.0), exact, 3000);
  const Eigen::Matrix3d m = q.matrix();
  attack(oriented_box(center, half,
                      rotation_in_space(
                          {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)})),
         Box::cube(3, 1.0), exact, 1000);
}

TEST(OrientedBox, BadOnesAreNamed) {
  const auto made = [](const std::string& keys, int dimension) {
    return message_of([&] {
      region_of(
          "type = \"oriented_box\"\ncenter = [0, 0" + std::string(dimension == 3 ? ", 0" : "") + "]\n" + keys,
          dimension);
    });
  };
  expect_message(made("half_sizes = [1, 0]", 2), "half_sizes[1]");
  expect_message(made("half_sizes = [1]", 2), "half_sizes has 1 numbers");
  expect_message(made("half_sizes = [1, 1, 1]\nangle = 1", 3), "expected the key rotation");
  expect_message(made("half_sizes = [1, 1]\nrotation = [0, 0, 0, 1]", 2), "expected it in 3");
  expect_message(made("half_sizes = [1, 1, 1]\nrotation = [0, 0, 1]", 3), "found 3 numbers");
  expect_message(made("half_sizes = [1, 1, 1]\nrotation = [0, 0, 0, 0]", 3), "length 0");
  expect_message(made("half_sizes = [1, 1, 1]\nrotation = [1, 0, 0, 0, 1, 0, 0, 0, -1]", 3), "determinant");
  expect_message(made("half_sizes = [1, 1, 1]\nrotation = [1, 0, 0, 0, 1, 0, 0, 0.5, 1]", 3), "transpose");
}

double segment_distance(const Vector& a, const Vector& b, const Vector& x) {
  const double t = std::min(1.0, std::max(0.0, (x - a).dot(b - a) / (b - a).squaredNorm()));
  return (x - a - t * (b - a)).norm();
}

TEST(Capsule, SoundAndTight) {
  for (const Eigen::Index n : {2, 3, 5}) {
    Vector a = Vector::Constant(n, -0.3), b = Vector::Constant(n, 0.2);
    b[0] = 0.6;
    attack(
        capsule(a, b, 0.4), Box::cube(n, n == 5 ? 0.6 : 1.2),
        [&](const Vector& x) { return segment_distance(a, b, x) - 0.4; }, 3000);
  }
  const RegionPtr point = capsule(Vector{{1.0, 1.0}}, Vector{{1.0, 1.0}}, 0.5);
  EXPECT_NEAR(point->level(Points{{1.0, 2.0}})[0], 0.5, 1e-15);
  expect_message(message_of([] { region_of("type = \"capsule\"\nstart = [0, 0]\nend = [1, 0]", 2); }),
                 "radius");
  expect_message(
      message_of([] { region_of("type = \"capsule\"\nstart = [0]\nend = [1, 0]\nradius = 1", 2); }),
      "start has 1");
}

TEST(Cylinder, SoundAndTight) {
  const Vector a{{-0.3, -0.2, 0.1}}, b{{0.5, 0.4, 0.3}};
  const RegionPtr region =
      region_of("type = \"cylinder\"\nstart = [-0.3, -0.2, 0.1]\nend = [0.5, 0.4, 0.3]\nradius = 0.35", 3);
  attack(
      region, Box::cube(3, 1.0),
      [&](const Vector& x) {
        const Eigen::Vector3d axis = (b - a).normalized(), to = x - a;
        const double along = std::max(-to.dot(axis), to.dot(axis) - (b - a).norm());
        const double aside = to.cross(axis).norm() - 0.35;
        return std::hypot(std::max(along, 0.0), std::max(aside, 0.0)) + std::min(0.0, std::max(along, aside));
      },
      3000);
  EXPECT_EQ(region->describe(), "cylinder from (-0.3, -0.2, 0.1) to (0.5, 0.4, 0.3) radius 0.35");
  expect_message(message_of([&] { cylinder(a, a, 1.0); }), "differ");
  expect_message(message_of([&] { region_of("type = \"cylinder\"\nradius = 1", 2); }), "expected 3");
}

TEST(Polytope, HalfspacesAndHulls) {
  // An octahedron, by its faces and by its vertices.
  const std::string faces =
      "type = \"polytope\"\nnormals = "
      "[[1,1,1],[1,1,-1],[1,-1,1],[1,-1,-1],[-1,1,1],[-1,1,-1],[-1,-1,1],[-1,-1,-1]]"
      "\noffsets = [0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6]";
  const std::string corners =
      "type = \"polytope\"\nvertices = "
      "[[0.6,0,0],[-0.6,0,0],[0,0.6,0],[0,-0.6,0],[0,0,0.6],[0,0,-0.6],[0,0,0]]";
  const Reference exact = [](const Vector& x) { return (x.lpNorm<1>() - 0.6) / std::sqrt(3.0); };
  attack(region_of(faces, 3), Box::cube(3, 0.6), exact, 2000);
  attack(region_of(corners, 3), Box::cube(3, 0.6), exact, 2000);
  // Every vertex is in the hull, rounding included.
  RandomStream random(3, "hull");
  const Points cloud = uniform_points(Box::cube(3, 0.7), 60, random);
  const RegionPtr hull = convex_hull(cloud);
  for (Eigen::Index k = 0; k < cloud.rows(); ++k) {
    const Vector x = cloud.row(k).transpose();
    EXPECT_NE(hull->classify({x, x}), Location::outside);
    for (Eigen::Index j = 0; j < k; ++j) {
      EXPECT_TRUE(hull->contains(0.45 * x + 0.55 * cloud.row(j).transpose())) << k << " " << j;
    }
  }
  EXPECT_FALSE(hull->contains(Vector{{0.0, 0.0, 0.71}}));
  // In the plane the hull is a polygon.
  const RegionPtr flat =
      region_of("type = \"polytope\"\nvertices = [[0,0],[1,1],[1,0],[0.5,0.5],[0,1],[0.5,0]]", 2);
  EXPECT_NEAR(flat->level(Points{{2.0, 2.0}})[0], std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(flat->level(Points{{0.5, 0.25}})[0], -0.25, 1e-15);
}

TEST(Polytope, BadOnesAreNamed) {
  const auto made = [](const std::string& keys, int n) {
    return message_of([&] { region_of("type = \"polytope\"\n" + keys, n); });
  };
  expect_message(made("", 2), "one of the keys vertices");
  expect_message(made("normals = [[1, 0]]\noffsets = [1, 2]", 2), "1 normals and 2 offsets");
  expect_message(made("normals = [[0, 0]]\noffsets = [1]", 2), "normal");
  expect_message(made("vertices = [[0, 0], [1, 1], [2, 2]]", 2), "one line");
  expect_message(made("vertices = [[0, 0, 0], [1, 1, 0], [2, 2, 0], [0, 1, 0]]", 3), "one plane");
  expect_message(made("vertices = [[0, 0, 0], [1, 1, 0]]", 3), "expected 4 to 200");
}

TEST(Shapes, BoundaryPointsLieOnThemWithNormalsOfLengthOne) {
  const RegionPtr shapes[] = {polygon(kArrow, {kHole}),
                              oriented_box(Vector{{0.1, 0.1}}, Vector{{0.3, 0.2}}, rotation_by_angle(0.4)),
                              capsule(Vector{{-0.3, 0.0}}, Vector{{0.3, 0.2}}, 0.2)};
  RandomStream random(5, "boundary");
  for (const RegionPtr& shape : shapes) {
    const BoundaryPoints boundary = boundary_points(shape, Box::cube(2, 1.0), 400, random);
    ASSERT_GT(boundary.point.rows(), 200) << shape->describe();
    EXPECT_LE(shape->level(boundary.point).cwiseAbs().maxCoeff(), 1e-9);
    const Vector beyond = shape->level(boundary.point + 0.001 * boundary.normal);
    EXPECT_GT((beyond.array() > 0.0009).count(), boundary.point.rows() * 9 / 10) << shape->describe();
  }
}

TEST(Shapes, SaveNothingOfInfiniteBoxesAndRefuseWhatIsNoNumber) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const RegionPtr& shape :
       {polygon(kArrow), capsule(Vector{{0.0, 0.0}}, Vector{{1.0, 0.0}}, 0.1),
        oriented_box(Vector{{0.0, 0.0}}, Vector{{1.0, 1.0}}, rotation_by_angle(0.1))}) {
    EXPECT_EQ(shape->classify({Vector{{-infinity, 5.0}}, Vector{{0.0, infinity}}}), Location::unknown);
    EXPECT_EQ(shape->classify({Vector{{0.0, std::nan("")}}, Vector{{0.0, 1.0}}}), Location::unknown);
    EXPECT_THROW(shape->level(Points{{0.0, std::nan("")}}), Error);
    EXPECT_THROW(shape->level(Points::Zero(1, 3)), Error);
  }
}

}  // namespace
}  // namespace s2nnds
