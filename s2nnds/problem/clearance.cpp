// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

namespace s2nnds {
namespace {

// Where boxes are too many to decide much, few bound the distance nearly as well.
constexpr int kMostBoxes = 200'000, kMostBoxesBeyondThree = 10'000;
constexpr double kDifference = 1e-6;  // of a gradient, in the region's coordinates

// A box, and where it is nearest to the points.
struct Candidate {
  Box box;
  double distance;
  Eigen::Index point;  // the row of the nearest point
  bool operator<(const Candidate& other) const { return distance > other.distance; }  // nearest first
};

Vector nearest_in(const Box& box, const Vector& point) {
  return point.cwiseMax(box.lower).cwiseMin(box.upper);
}

Candidate make_candidate(Box box, const Points& points) {
  double least = std::numeric_limits<double>::infinity();
  Eigen::Index nearest = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    double squared = 0.0;
    for (Eigen::Index j = 0; j < points.cols() && squared < least; ++j) {
      const double beside = std::max({box.lower[j] - points(i, j), points(i, j) - box.upper[j], 0.0});
      squared += beside * beside;
    }
    if (squared < least) {
      least = squared;
      nearest = i;
    }
  }
  return {std::move(box), std::sqrt(least), nearest};
}

Vector gradient(const Region& region, const Vector& x) {
  Points around(2 * x.size(), x.size());
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    around.row(2 * j) = around.row(2 * j + 1) = x.transpose();
    around(2 * j, j) += kDifference;
    around(2 * j + 1, j) -= kDifference;
  }
  const Vector level = region.level(around);
  Vector slope(x.size());
  for (Eigen::Index j = 0; j < x.size(); ++j)
    slope[j] = (level[2 * j] - level[2 * j + 1]) / (2 * kDifference);
  return slope;
}

// A level that is 1-Lipschitz is a lower bound of the distance, and `least` that of the points, at `from`. Where a
// step straight down the level finds a point of the region no farther than least + tolerance, no box is needed:
// in many dimensions boxes are too many.
std::optional<Clearance> straight_down(const Region& region, const Vector& from, double least,
                                       const Box& within, double tolerance) {
  const Vector slope = gradient(region, from);
  if (!(slope.norm() > 0)) return std::nullopt;
  Vector to = from - (least + 0.5 * tolerance) * slope.normalized();
  const bool inside =
      (to.array() >= within.lower.array()).all() && (to.array() <= within.upper.array()).all();
  if (!inside || !region.contains(to)) return std::nullopt;
  return Clearance{least, std::move(to), from, 0};
}

}  // namespace

// Best first: the nearest box that is inside, or whose nearest point is in the region, has the least distance.
Clearance clearance(const Region& region, const Points& points, const Box& within, double tolerance) {
  Clearance result;
  const Vector level = region.level(points);
  Eigen::Index lowest = 0;
  const double least = level.minCoeff(&lowest);
  result.inside = (level.array() <= 0.0).count();
  if (result.inside > 0) {
    result.at = result.in_region = points.row(lowest).transpose();
    return result;
  }
  if (region.is_lipschitz() && std::isfinite(least)) {
    std::optional<Clearance> found =
        straight_down(region, points.row(lowest).transpose(), least, within, tolerance);
    if (found) return *found;
  }
  const int most = within.dimension() > 3 ? kMostBoxesBeyondThree : kMostBoxes;
  std::priority_queue<Candidate> open;
  open.push(make_candidate(within, points));
  for (int count = 0; !open.empty(); ++count) {
    const Candidate next = open.top();
    open.pop();
    const Location location = region.classify(next.box);
    if (location == Location::outside) continue;
    const Vector point = points.row(next.point).transpose();
    const Vector nearest = nearest_in(next.box, point);
    const Eigen::Index side = next.box.widest_side();
    const double width = next.box.upper[side] - next.box.lower[side];
    const double diagonal = (next.box.upper - next.box.lower).norm();
    if (location == Location::inside || diagonal <= tolerance || region.contains(nearest) || count >= most ||
        !(width > 0)) {
      // Where the search was cut, both are at most the true distance.
      const bool cut = count >= most && region.is_lipschitz();
      result.distance = cut ? std::max(next.distance, least) : next.distance;
      result.in_region = nearest;
      result.at = point;
      return result;
    }
    auto [lower, upper] = next.box.bisect(side);
    open.push(make_candidate(std::move(lower), points));
    open.push(make_candidate(std::move(upper), points));
  }
  result.distance = std::numeric_limits<double>::infinity();
  return result;
}

}  // namespace s2nnds
