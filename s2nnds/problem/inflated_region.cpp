// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/inflated_region.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/simplex.h"

namespace s2nnds {
namespace {

std::string described(const Region& region, double radius) {
  return fmt::format("[{}] inflated by {:.6g}", region.describe(), radius);
}

class InflatedDistance final : public Region {
 public:
  InflatedDistance(RegionPtr region, double radius) : region_(std::move(region)), radius_(radius) {}
  Eigen::Index dimension() const override { return region_->dimension(); }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override { return described(*region_, radius_); }
  std::optional<HalfspaceBound> bounding_halfspace(const Box& box, double level) const override {
    return region_->bounding_halfspace(box, next_up(level + radius_));
  }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    level = region_->level(x).array() - radius_;
  }
  Interval enclose(const Box& box) const override { return region_->enclosure(box) - radius_; }

 private:
  RegionPtr region_;
  double radius_;
};

// Boxes of equal size that together hold the ball of `radius` around 0 and little more.
std::vector<Box> cells_of_ball(Eigen::Index dimension, double radius) {
  const int sides = dimension == 1 ? 16 : dimension == 2 ? 12 : dimension == 3 ? 6 : dimension == 4 ? 3 : 1;
  const double reach = next_up(radius), step = 2.0 * reach / sides;
  std::vector<Box> cells;
  std::vector<int> index(static_cast<std::size_t>(dimension), 0);
  for (;;) {
    Box cell{Vector(dimension), Vector(dimension)};
    for (Eigen::Index i = 0; i < dimension; ++i) {
      const int k = index[static_cast<std::size_t>(i)];
      cell.lower[i] = k == 0 ? -reach : -reach + k * step;
      cell.upper[i] = k == sides - 1 ? reach : -reach + (k + 1) * step;
    }
    const Position zero = Position::Zero(dimension);
    if (box_distance(cell.lower, cell.upper, zero, zero).lower <= radius) cells.push_back(cell);
    Eigen::Index axis = 0;
    while (axis < dimension && ++index[static_cast<std::size_t>(axis)] == sides) {
      index[static_cast<std::size_t>(axis++)] = 0;
    }
    if (axis == dimension) return cells;
  }
}

class InflatedLevel final : public Region {
 public:
  InflatedLevel(RegionPtr region, double radius)
      : region_(std::move(region)), radius_(radius), cells_(cells_of_ball(region_->dimension(), radius)) {}
  Eigen::Index dimension() const override { return region_->dimension(); }
  bool is_lipschitz() const override { return false; }
  std::string describe() const override { return described(*region_, radius_); }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    level.resize(x.rows());
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      const Vector at = x.row(k).transpose();
      level[k] = least_within_radius({at, at});
    }
  }
  // From above: every point is within the radius of itself.
  Interval enclose(const Box& box) const override {
    const double lower = least_within_radius(box);
    return std::isnan(lower) ? Interval::undefined() : Interval(lower, region_->enclosure(box).upper);
  }

 private:
  // At most the level of every point within the radius of the box; NaN where it may not be defined.
  double least_within_radius(const Box& box) const {
    double least = std::numeric_limits<double>::infinity();
    Box moved = box;
    for (const Box& cell : cells_) {
      for (Eigen::Index i = 0; i < box.dimension(); ++i) {
        moved.lower[i] = next_down(box.lower[i] + cell.lower[i]);
        moved.upper[i] = next_up(box.upper[i] + cell.upper[i]);
      }
      const double lower = region_->enclosure(moved).lower;
      if (!(lower >= least)) least = lower;
      if (std::isnan(lower)) break;
    }
    return least;
  }

  RegionPtr region_;
  double radius_;
  std::vector<Box> cells_;
};

}  // namespace

RegionPtr inflated(RegionPtr region, double radius) {
  check(radius > 0.0 && std::isfinite(radius), "inflate: found {}, expected a finite number > 0", radius);
  if (region->is_lipschitz()) return std::make_shared<InflatedDistance>(std::move(region), radius);
  return std::make_shared<InflatedLevel>(std::move(region), radius);
}

}  // namespace s2nnds
