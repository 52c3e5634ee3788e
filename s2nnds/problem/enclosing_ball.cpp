// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/enclosing_ball.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr std::size_t kCover = 2000;  // boxes that the center is found from
constexpr int kMostBoxes = 100'000;   // that one bound looks at
constexpr int kSteps = 2000;          // of the search for the center, which proves nothing
constexpr double kSlack = 1e-3;       // of the radius, and a tenth of it of the box: where a search ends

Interval side(const Box& box, Eigen::Index axis) { return {box.lower[axis], box.upper[axis]}; }

// Of all points of the box, in the first coordinates.
Interval distance_to(const Box& box, const Vector& center) {
  Interval sum = 0.0;
  for (Eigen::Index i = 0; i < center.size(); ++i) sum += square(side(box, i) - center[i]);
  return sqrt(sum);
}

Eigen::Index widest_place(const Box& box, Eigen::Index places) {
  Eigen::Index widest = 0;
  (box.upper - box.lower).head(places).maxCoeff(&widest);
  return widest;
}

// Boxes that hold every point of the region, about as many as kCover.
std::vector<Box> cover_of(const Region& region, const Box& within, Eigen::Index places) {
  std::vector<Box> cover = {within};
  for (int halvings = 0; !cover.empty() && cover.size() < kCover && halvings < 60 * places; ++halvings) {
    std::vector<Box> next;
    for (const Box& box : cover) {
      auto [lower, upper] = box.bisect(widest_place(box, places));
      for (Box* half : {&lower, &upper})
        if (region.classify(*half) != Location::outside) next.push_back(std::move(*half));
    }
    cover = std::move(next);
  }
  return cover;
}

// The nearest of many candidates to the center of the smallest ball around the boxes' middles: the farthest one pulls, less
// and less (Badoiu, Clarkson, Smaller core-sets for balls, 2003). From the middle of the box around all.
Vector find_center(const std::vector<Box>& cover, Eigen::Index places) {
  Points middles(static_cast<Eigen::Index>(cover.size()), places);
  for (std::size_t k = 0; k < cover.size(); ++k)
    middles.row(static_cast<Eigen::Index>(k)) = cover[k].center().head(places).transpose();
  Vector center = 0.5 * (middles.colwise().minCoeff() + middles.colwise().maxCoeff()).transpose(),
         best = center;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 1; k <= kSteps; ++k) {
    Eigen::Index farthest = 0;
    const double radius =
        std::sqrt((middles.rowwise() - center.transpose()).rowwise().squaredNorm().maxCoeff(&farthest));
    if (radius < least) least = radius, best = center;
    center += (middles.row(farthest).transpose() - center) / (k + 1.0);
  }
  return best;
}

// The largest bound first: that of a box that is small or lies inside is one of all.
struct Candidate {
  Box box;
  double bound;
  bool operator<(const Candidate& other) const { return bound < other.bound; }
};

// The least upper bound that kMostBoxes boxes prove, of `bound` of each point of the region; -infinity if there is none.
template <typename Bound>
double largest_bound(const Region& region, const std::vector<Box>& cover, Eigen::Index places,
                     double tolerance, const Bound& bound) {
  std::priority_queue<Candidate> open;
  for (const Box& box : cover) open.push({box, bound(box)});
  for (int count = 0; !open.empty(); ++count) {
    const Candidate next = open.top();
    const Eigen::Index axis = widest_place(next.box, places);
    if (count >= kMostBoxes || !(next.box.upper[axis] - next.box.lower[axis] > tolerance)) return next.bound;
    open.pop();
    auto [lower, upper] = next.box.bisect(axis);
    for (Box* half : {&lower, &upper}) {
      if (region.classify(*half) == Location::outside) continue;
      const double found = bound(*half);
      open.push({std::move(*half), found});
    }
  }
  return -std::numeric_limits<double>::infinity();
}

void check_places(const Region& region, const Box& within, Eigen::Index places) {
  check(within.is_finite() && !within.is_empty() && within.dimension() == region.dimension() && places > 0 &&
            places <= within.dimension(),
        "enclosing ball: found {} coordinates of places and a box in {} dimensions, expected a finite box in "
        "the "
        "region's {}",
        places, within.dimension(), region.dimension());
}

}  // namespace

std::optional<EnclosingBall> enclosing_ball(const Region& region, const Box& within, Eigen::Index places) {
  check_places(region, within, places);
  const std::vector<Box> cover = cover_of(region, within, places);
  double volume = 0.0;
  for (const Box& box : cover) volume += box.volume();
  if (cover.empty() || !(volume <= 0.5 * within.volume())) return std::nullopt;
  EnclosingBall found{find_center(cover, places), 0.0};
  const auto reach = [&](const Box& box) { return distance_to(box, found.center).upper; };
  double rough = 0.0;
  for (const Box& box : cover) rough = std::max(rough, reach(box));
  found.radius = largest_bound(region, cover, places, kSlack * rough, reach);
  if (!(found.radius > 0.0)) return std::nullopt;
  return found;
}

double distance_below(const Region& region, const Box& within, const Vector& center) {
  const Eigen::Index places = center.size();
  check_places(region, within, places);
  const auto nearness = [&](const Box& box) { return -distance_to(box, center).lower; };
  const double tolerance = 0.1 * kSlack * (within.upper - within.lower).head(places).maxCoeff();
  return -largest_bound(region, {within}, places, tolerance, nearness);
}

}  // namespace s2nnds
