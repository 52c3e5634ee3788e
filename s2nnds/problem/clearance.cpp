// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/clearance.h"

#include <limits>
#include <queue>
#include <utility>

namespace s2nnds {
namespace {

constexpr int kMostBoxes = 1'000'000;

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
  Candidate found{std::move(box), std::numeric_limits<double>::infinity(), 0};
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vector point = points.row(i).transpose();
    const double distance = (nearest_in(found.box, point) - point).norm();
    if (distance < found.distance) {
      found.distance = distance;
      found.point = i;
    }
  }
  return found;
}

}  // namespace

// Best first: the nearest box that is inside, or whose nearest point is in the region, has the least distance.
Clearance clearance(const Region& region, const Points& points, const Box& within, double tolerance) {
  Clearance result;
  result.inside = (region.level(points).array() <= 0.0).count();
  if (result.inside > 0) {
    Eigen::Index deepest = 0;
    region.level(points).minCoeff(&deepest);
    result.at = result.in_region = points.row(deepest).transpose();
    return result;
  }
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
    if (location == Location::inside || diagonal <= tolerance || region.contains(nearest) ||
        count >= kMostBoxes || !(width > 0)) {
      result.distance = next.distance;
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
