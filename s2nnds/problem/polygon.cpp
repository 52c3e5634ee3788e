// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/polygon.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/surface_region.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kMostListed = 16;  // corners in describe()

std::string text(const Points& corners) {
  std::vector<std::string> parts;
  for (Eigen::Index k = 0; k < std::min(corners.rows(), kMostListed); ++k) {
    parts.push_back(fmt::format("({}, {})", corners(k, 0), corners(k, 1)));
  }
  if (corners.rows() > kMostListed) parts.push_back(fmt::format("and {} more", corners.rows() - kMostListed));
  return fmt::format("{}", fmt::join(parts, " "));
}

// Twice the signed area of the triangle a b c; positive when it turns left.
Interval turn(const Eigen::Ref<const Eigen::RowVector2d>& a, const Eigen::Ref<const Eigen::RowVector2d>& b,
              const Position& c) {
  return (Interval(b[0]) - a[0]) * (Interval(c[1]) - a[1]) -
         (Interval(b[1]) - a[1]) * (Interval(c[0]) - a[0]);
}

class Polygon final : public SurfaceRegion {
 public:
  Polygon(SimplexSet edges, std::string text) : SurfaceRegion(std::move(edges)), text_(std::move(text)) {}
  std::string describe() const override { return text_; }

 protected:
  // The parity of the edges that a ray from x to the right crosses. Comparisons of coordinates are exact, and
  // an edge counts its lower end and not its upper one, so that a ray through a corner is counted rightly.
  int side(const Position& x) const override {
    int result = 1;
    const auto meets = [&](const Position& lower, const Position& upper) {
      return lower[1] <= x[1] && x[1] <= upper[1] && x[0] <= upper[0];
    };
    const auto cross = [&](std::size_t k) {
      const auto row = static_cast<Eigen::Index>(k);
      Eigen::RowVector2d low = surface().vertices().row(surface().simplices()(row, 0));
      Eigen::RowVector2d high = surface().vertices().row(surface().simplices()(row, 1));
      if (low[1] > high[1]) std::swap(low, high);
      if (x[1] < low[1] || x[1] >= high[1]) return true;
      const Interval left = turn(low, high, x);  // positive: x lies to the left of the edge
      if (left.lower > 0.0) result = -result;
      return left.lower > 0.0 || left.upper < 0.0;
    };
    return surface().tree().visit(meets, cross) ? result : 0;
  }

 private:
  std::string text_;
};

// Whether two segments have a point in common, as exactly as doubles say; touching counts.
bool meet(const Eigen::RowVector2d& a, const Eigen::RowVector2d& b, const Eigen::RowVector2d& c,
          const Eigen::RowVector2d& d) {
  for (int i = 0; i < 2; ++i) {
    if (std::max(a[i], b[i]) < std::min(c[i], d[i]) || std::max(c[i], d[i]) < std::min(a[i], b[i]))
      return false;
  }
  const auto one_side = [](const Eigen::RowVector2d& p, const Eigen::RowVector2d& q,
                           const Eigen::RowVector2d& r, const Eigen::RowVector2d& s) {
    const Interval first = turn(p, q, r.transpose()), second = turn(p, q, s.transpose());
    return (first.lower > 0.0 && second.lower > 0.0) || (first.upper < 0.0 && second.upper < 0.0);
  };
  return !one_side(a, b, c, d) && !one_side(c, d, a, b);
}

// Whether the edges after and before a corner leave it in the same direction, one upon the other.
bool folds(const Eigen::RowVector2d& before, const Eigen::RowVector2d& corner,
           const Eigen::RowVector2d& after) {
  const Interval left = turn(before, corner, after.transpose());
  return left.contains(0.0) && (before - corner).dot(after - corner) > 0.0;
}

// The corners of a ring, one row of the list after the other, and its edges.
void add_ring(const Points& ring, const std::string& name, Points& vertices, Eigen::MatrixXi& edges) {
  check(ring.rows() >= 3 && ring.cols() == 2 && ring.allFinite(),
        "polygon: {} has {} corners of {} coordinates, expected at least 3 of 2 finite ones", name,
        ring.rows(), ring.cols());
  const Eigen::Index first = vertices.rows(), count = ring.rows();
  vertices.conservativeResize(first + count, 2);
  edges.conservativeResize(first + count, 2);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index next = (k + 1) % count;
    check((ring.row(k).array() != ring.row(next).array()).any(),
          "polygon: corners {} and {} of {} are the same, ({}, {}); expected different ones", k, next, name,
          ring(k, 0), ring(k, 1));
    vertices.row(first + k) = ring.row(k);
    edges.row(first + k) << static_cast<int>(first + k), static_cast<int>(first + next);
  }
}

void check_simple(const Points& vertices, const Eigen::MatrixXi& edges) {
  const auto point = [&](Eigen::Index edge, int end) -> Eigen::RowVector2d {
    return vertices.row(edges(edge, end));
  };
  for (Eigen::Index i = 0; i < edges.rows(); ++i) {
    for (Eigen::Index j = i + 1; j < edges.rows(); ++j) {
      const bool follows = edges(i, 1) == edges(j, 0), leads = edges(j, 1) == edges(i, 0);
      const bool wrong = follows ? folds(point(i, 0), point(i, 1), point(j, 1))
                         : leads ? folds(point(j, 0), point(j, 1), point(i, 1))
                                 : meet(point(i, 0), point(i, 1), point(j, 0), point(j, 1));
      check(!wrong,
            "polygon: the edges from ({}, {}) and from ({}, {}) meet; expected edges that neither cross nor "
            "touch",
            point(i, 0)[0], point(i, 0)[1], point(j, 0)[0], point(j, 0)[1]);
    }
  }
}

// That each hole lies within the outline and outside of every other hole. No edges meet, so one corner says
// where a ring lies. Without this an odd number of rings around a point would fill a hole again.
void check_holes(const Points& corners, const std::vector<Points>& holes) {
  if (holes.empty()) return;
  const auto location = [](const RegionPtr& ring, const Points& hole) {
    const Vector corner = hole.row(0).transpose();
    return ring->classify({corner, corner});
  };
  const RegionPtr outline = polygon(corners);
  for (std::size_t k = 0; k < holes.size(); ++k) {
    check(location(outline, holes[k]) == Location::inside,
          "polygon: hole {} lies outside; expected holes within the polygon", k);
    const RegionPtr hole = polygon(holes[k]);
    for (std::size_t other = 0; other < holes.size(); ++other) {
      check(other == k || location(hole, holes[other]) == Location::outside,
            "polygon: hole {} lies within hole {}; expected holes side by side, and a polygon of its own for "
            "an island",
            other, k);
    }
  }
}

}  // namespace

RegionPtr polygon(const Points& corners, const std::vector<Points>& holes) {
  Points vertices(0, 2);
  Eigen::MatrixXi edges(0, 2);
  add_ring(corners, "vertices", vertices, edges);
  std::string described = "polygon " + text(corners);
  for (std::size_t k = 0; k < holes.size(); ++k) {
    add_ring(holes[k], fmt::format("hole {}", k), vertices, edges);
    described += " with the hole " + text(holes[k]);
  }
  check_simple(vertices, edges);
  check_holes(corners, holes);
  return std::make_shared<Polygon>(SimplexSet(vertices, edges), described);
}

}  // namespace s2nnds
