// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/mesh.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/side_grid.h"
#include "s2nnds/problem/surface_region.h"
#include "s2nnds/problem/triangle_distance.h"

namespace s2nnds {
namespace {

using Intervals = std::array<Interval, 3>;

// Rays in these directions pass edges and vertices of meshes made by people only by accident.
constexpr std::array<std::array<double, 3>, 4> kRays{{{0.5407, 0.7193, 0.4363},
                                                      {-0.3217, 0.2741, 0.9063},
                                                      {0.8039, -0.5791, -0.1361},
                                                      {-0.6173, -0.4201, -0.6653}}};

Intervals cross(const Intervals& a, const Intervals& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Interval dot(const Intervals& a, const Intervals& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

int sign_of(const Interval& a) { return a.lower > 0.0 ? 1 : a.upper < 0.0 ? -1 : 0; }

// Whether the ray may meet the box: not false unless that is sure.
bool may_meet(const Position& from, const std::array<double, 3>& ray, const Position& lower,
              const Position& upper) {
  Interval along(0.0, std::numeric_limits<double>::infinity());
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Interval direction = ray[static_cast<std::size_t>(i)];
    along = intersection(along, (Interval(lower[i], upper[i]) - from[i]) / direction);
    if (along.lower > along.upper) return false;
  }
  return true;
}

// What a ray from the origin adds to the winding number by passing the triangle a b c: 1 where it leaves, -1
// where it enters, 0 where it does not meet it; none if rounding hides which.
std::optional<int> crossing(const Intervals& ray, const Intervals& a, const Intervals& b,
                            const Intervals& c) {
  const Intervals ab = cross(a, b), bc = cross(b, c), ca = cross(c, a);
  const int left = sign_of(dot(ray, ab)), right = sign_of(dot(ray, bc)), below = sign_of(dot(ray, ca));
  const int least = std::min({left, right, below}), greatest = std::max({left, right, below});
  if (least < 0 && greatest > 0) return 0;               // the line passes by
  if (least == 0 || greatest == 0) return std::nullopt;  // through an edge or a vertex, or nearly
  // The line meets the plane of the triangle ahead where the origin's height over it has the sign of the
  // normal along the ray.
  const int height = sign_of(dot(a, bc));
  if (height == 0) return std::nullopt;
  return height == left ? left : 0;
}

class Solid final : public SurfaceRegion {
 public:
  Solid(SimplexSet triangles, std::string text)
      : SurfaceRegion(std::move(triangles)),
        text_(std::move(text)),
        distance_(surface().vertices(), surface().simplices()),
        sides_(surface().tree(), [this](const Position& x) { return side_by_rays(x); }) {}
  std::string describe() const override { return text_; }

 protected:
  int side(const Position& x) const override {
    const BoxTree& tree = surface().tree();
    if ((x.array() < tree.lower().array()).any() || (x.array() > tree.upper().array()).any()) return 1;
    const int known = sides_.at(x);
    return known != 0 ? known : side_by_rays(x);
  }
  double rounded_distance(const Position& x) const override { return distance_(x); }

 private:
  int side_by_rays(const Position& x) const {
    for (const std::array<double, 3>& ray : kRays) {
      if (const std::optional<int> winding = winding_along(x, ray)) return *winding == 0 ? 1 : -1;
    }
    return 0;
  }

  std::optional<int> winding_along(const Position& x, const std::array<double, 3>& ray) const {
    int winding = 0;
    const Intervals direction{ray[0], ray[1], ray[2]};
    const auto meets = [&](const Position& lower, const Position& upper) {
      return may_meet(x, ray, lower, upper);
    };
    const bool clear = surface().tree().visit(meets, [&](std::size_t k) {
      const Simplex triangle = surface().simplex(k);
      std::array<Intervals, 3> corner;
      for (std::size_t i = 0; i < 3; ++i) {
        for (Eigen::Index j = 0; j < 3; ++j) {
          corner[i][static_cast<std::size_t>(j)] = Interval(triangle.vertex[i][j]) - x[j];
        }
      }
      const std::optional<int> passed = crossing(direction, corner[0], corner[1], corner[2]);
      winding += passed.value_or(0);
      return passed.has_value();
    });
    return clear ? std::optional<int>(winding) : std::nullopt;
  }

  std::string text_;
  TriangleDistance distance_;
  SideGrid sides_;
};

std::string at(const Points& vertices, int row) {
  return fmt::format("({}, {}, {})", vertices(row, 0), vertices(row, 1), vertices(row, 2));
}

// Every edge is passed as often from its one end to the other as back: only then does the winding number not
// depend on the ray.
void check_closed(const TriangleMesh& mesh, const std::string& text) {
  struct Passes {
    int there = 0, back = 0;
  };
  std::map<std::pair<int, int>, Passes> edges;
  for (Eigen::Index k = 0; k < mesh.triangles.rows(); ++k) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      const int from = mesh.triangles(k, i), to = mesh.triangles(k, (i + 1) % 3);
      Passes& passes = edges[{std::min(from, to), std::max(from, to)}];
      ++(from < to ? passes.there : passes.back);
    }
  }
  std::size_t open = 0, turned = 0;
  std::pair<int, int> first_open, first_turned;
  for (const auto& [edge, passes] : edges) {
    if (passes.there == passes.back) continue;
    const bool is_turned = (passes.there + passes.back) % 2 == 0;
    std::size_t& count = is_turned ? turned : open;
    if (count++ == 0) (is_turned ? first_turned : first_open) = edge;
  }
  check(open == 0, "{}: {} of {} edges are open, the first from {} to {}; expected a closed mesh", text, open,
        edges.size(), at(mesh.vertices, first_open.first), at(mesh.vertices, first_open.second));
  check(turned == 0,
        "{}: the triangles at {} of {} edges turn opposite ways, the first from {} to {}; expected a mesh "
        "with all "
        "triangles counter-clockwise seen from outside",
        text, turned, edges.size(), at(mesh.vertices, first_turned.first),
        at(mesh.vertices, first_turned.second));
}

double volume_of(const TriangleMesh& mesh) {
  double volume = 0.0;
  for (Eigen::Index k = 0; k < mesh.triangles.rows(); ++k) {
    const Eigen::RowVector3d a = mesh.vertices.row(mesh.triangles(k, 0)) - mesh.vertices.row(0);
    const Eigen::RowVector3d b = mesh.vertices.row(mesh.triangles(k, 1)) - mesh.vertices.row(0);
    const Eigen::RowVector3d c = mesh.vertices.row(mesh.triangles(k, 2)) - mesh.vertices.row(0);
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

}  // namespace

RegionPtr solid(TriangleMesh mesh, const std::string& text) {
  check(mesh.vertices.cols() == 3 && mesh.triangles.cols() == 3 && mesh.triangles.rows() >= 1,
        "{}: found {} triangles, expected at least one", text, mesh.triangles.rows());
  check(mesh.vertices.allFinite(), "{}: a coordinate is not a finite number", text);
  check(mesh.triangles.minCoeff() >= 0 && mesh.triangles.maxCoeff() < mesh.vertices.rows(),
        "{}: a triangle names vertex {}, expected one of {}", text, mesh.triangles.maxCoeff(),
        mesh.vertices.rows());
  check_closed(mesh, text);
  const double size = (mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff()).norm();
  const double volume = volume_of(mesh);
  check(std::abs(volume) > 1e-12 * size * size * size, "{}: holds the volume {}, expected a solid", text,
        volume);
  return std::make_shared<Solid>(SimplexSet(std::move(mesh.vertices), std::move(mesh.triangles)), text);
}

}  // namespace s2nnds
