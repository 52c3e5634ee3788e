// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/occupancy_region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/box_tree.h"
#include "s2nnds/problem/placed_region.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFar = 1e300;       // how far what lies beyond the map reaches
constexpr double kFarthest = 1e299;  // of the coordinates of which something is said

// A rectangle of cells: from first (inclusive) to last (exclusive) along both axes.
struct Rectangle {
  Eigen::Index first_x, last_x, first_y, last_y;
};

// The cells where `wanted` is true, as few rectangles: runs along x, joined where rows repeat them.
template <typename Wanted>
std::vector<Rectangle> rectangles_of(Eigen::Index width, Eigen::Index height, const Wanted& wanted) {
  std::vector<Rectangle> done;
  std::map<std::pair<Eigen::Index, Eigen::Index>, std::size_t> open;  // by their run
  for (Eigen::Index y = 0; y < height; ++y) {
    std::map<std::pair<Eigen::Index, Eigen::Index>, std::size_t> next;
    for (Eigen::Index x = 0; x < width;) {
      if (!wanted(x, y)) {
        ++x;
        continue;
      }
      const Eigen::Index first = x;
      while (x < width && wanted(x, y)) ++x;
      const auto known = open.find({first, x});
      const std::size_t index = known != open.end() ? known->second : done.size();
      if (known == open.end()) done.push_back({first, x, y, y});
      done[index].last_y = y + 1;
      next[{first, x}] = index;
    }
    open = std::move(next);
  }
  return done;
}

// The four parts of the plane around a map.
std::vector<std::pair<Eigen::RowVector2d, Eigen::RowVector2d>> around(double width, double height) {
  return {{{-kFar, -kFar}, {0.0, kFar}},
          {{width, -kFar}, {kFar, kFar}},
          {{-kFar, -kFar}, {kFar, 0.0}},
          {{-kFar, height}, {kFar, kFar}}};
}

// With all that lies around the map, if `beyond`.
BoxTree tree_of(const std::vector<Rectangle>& rectangles, const OccupancyMap& map, bool beyond) {
  const auto line = [&](Eigen::Index k) { return static_cast<double>(k) * map.resolution; };
  const auto outer = around(line(map.cells.rows()), line(map.cells.cols()));
  const auto count = static_cast<Eigen::Index>(rectangles.size() + (beyond ? outer.size() : 0));
  Points lower(count, 2), upper(count, 2);
  Eigen::Index row = 0;
  for (const Rectangle& r : rectangles) {
    lower.row(row) << line(r.first_x), line(r.first_y);
    upper.row(row++) << line(r.last_x), line(r.last_y);
  }
  for (std::size_t k = 0; row < count; ++k) {
    lower.row(row) = outer[k].first;
    upper.row(row++) = outer[k].second;
  }
  return BoxTree(lower, upper);
}

// Of a box, or of a point with equal corners.
Interval distance(const BoxTree& tree, const Position& lower, const Position& upper) {
  Interval least(kInfinity, kInfinity);
  tree.search([&](const Position& low,
                  const Position& high) { return least_squared_distance(low, high, lower, upper); },
              [&](std::size_t k) {
                least = min(least, box_distance(tree.item_lower(k), tree.item_upper(k), lower, upper));
                return least.upper > 0.0 ? greatest_square(least.upper) : -kInfinity;  // no box is nearer
              });
  return least;
}

double rounded_distance(const BoxTree& tree, const Position& x) {
  double least = kInfinity;
  tree.search(
      [&](const Position& low, const Position& high) { return rounded_squared_distance(low, high, x, x); },
      [&](std::size_t k) {
        least = std::min(least, rounded_squared_distance(tree.item_lower(k), tree.item_upper(k), x, x));
        return least > 0.0 ? least : -kInfinity;
      });
  return std::sqrt(least);
}

// In the map's own axes: the corner of the cell (0, 0) at the origin.
class OccupiedCells final : public Region {
 public:
  OccupiedCells(BoxTree occupied, BoxTree free) : occupied_(std::move(occupied)), free_(std::move(free)) {}
  Eigen::Index dimension() const override { return 2; }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override { return "occupied cells"; }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    level.resize(x.rows());
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      const Position at = x.row(k).transpose();
      if (!at.allFinite()) {
        level[k] = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      const double outside = rounded_distance(occupied_, at);
      level[k] = outside > 0.0 ? outside : -rounded_distance(free_, at);
    }
  }
  Interval enclose(const Box& box) const override {
    if (!(box.lower.cwiseAbs().maxCoeff() <= kFarthest && box.upper.cwiseAbs().maxCoeff() <= kFarthest)) {
      return {-kInfinity, kInfinity};
    }
    const Interval outside = distance_over(occupied_, box);
    if (outside.lower > 0.0) return outside;
    const Interval inside = distance_over(free_, box);
    if (inside.lower > 0.0) return -inside;
    return {-inside.upper, outside.upper};
  }

 private:
  static Interval distance_over(const BoxTree& tree, const Box& box) {
    const Position center = box.center();
    return {distance(tree, box.lower, box.upper).lower,
            lipschitz_enclosure(distance(tree, center, center), box).upper};
  }

  BoxTree occupied_, free_;
};

}  // namespace

RegionPtr occupied_cells(const OccupancyMap& map, bool unknown_is_occupied, const std::string& text) {
  const Cell unknown_as = unknown_is_occupied ? Cell::occupied : Cell::free;
  const auto cells = [&](Cell kind) {
    return rectangles_of(map.cells.rows(), map.cells.cols(), [&](Eigen::Index x, Eigen::Index y) {
      return (map.cells(x, y) == Cell::unknown ? unknown_as : map.cells(x, y)) == kind;
    });
  };
  const std::vector<Rectangle> occupied = cells(Cell::occupied), free = cells(Cell::free);
  check(!occupied.empty() || unknown_is_occupied, "{}: found no occupied cells, expected at least one", text);
  check(!free.empty() || !unknown_is_occupied, "{}: found no free cells, expected at least one", text);
  const RegionPtr region = std::make_shared<OccupiedCells>(tree_of(occupied, map, unknown_is_occupied),
                                                           tree_of(free, map, !unknown_is_occupied));
  return placed(region, map.yaw == 0.0 ? no_rotation(2) : rotation_by_angle(map.yaw), map.origin, text);
}

}  // namespace s2nnds
