// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/simplex_set.h"

#include <algorithm>
#include <limits>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

BoxTree tree_over(const Points& vertices, const Eigen::MatrixXi& simplices) {
  check(simplices.cols() >= 1 && simplices.cols() <= 3 && simplices.rows() >= 1,
        "simplices: found [{}, {}], expected at least one of 1 to 3 vertices", simplices.rows(),
        simplices.cols());
  check(simplices.minCoeff() >= 0 && simplices.maxCoeff() < vertices.rows(),
        "simplices: expected vertices from 0 to {}, found {} to {}", vertices.rows() - 1,
        simplices.minCoeff(), simplices.maxCoeff());
  Points lower = vertices(simplices.col(0), Eigen::all), upper = lower;
  for (Eigen::Index k = 1; k < simplices.cols(); ++k) {
    lower = lower.cwiseMin(vertices(simplices.col(k), Eigen::all));
    upper = upper.cwiseMax(vertices(simplices.col(k), Eigen::all));
  }
  return BoxTree(lower, upper);
}

}  // namespace

SimplexSet::SimplexSet(Points vertices, Eigen::MatrixXi simplices)
    : vertices_(std::move(vertices)),
      simplices_(std::move(simplices)),
      tree_(tree_over(vertices_, simplices_)) {}

Simplex SimplexSet::simplex(std::size_t k) const {
  Simplex result;
  result.count = static_cast<int>(simplices_.cols());
  for (Eigen::Index i = 0; i < simplices_.cols(); ++i) {
    result.vertex[static_cast<std::size_t>(i)] =
        vertices_.row(simplices_(static_cast<Eigen::Index>(k), i)).transpose();
  }
  return result;
}

Interval SimplexSet::distance(const Position& x) const {
  Interval least(kInfinity, kInfinity);
  tree_.search([&](const Position& lower,
                   const Position& upper) { return least_squared_distance(lower, upper, x, x); },
               [&](std::size_t k) {
                 least = min(least, simplex(k).distance(x));
                 return greatest_square(least.upper);
               });
  return least;
}

double SimplexSet::rounded_distance(const Position& x) const {
  double least = kInfinity;
  tree_.search([&](const Position& lower,
                   const Position& upper) { return rounded_squared_distance(lower, upper, x, x); },
               [&](std::size_t k) {
                 least = std::min(least, simplex(k).rounded_distance(x));
                 return least * least;
               });
  return least;
}

double SimplexSet::gap(const Box& box) const {
  const Position center = box.center(), half_widths = box.half_widths();
  const Position low = box.lower, high = box.upper;
  double least = kInfinity;
  tree_.search([&](const Position& lower,
                   const Position& upper) { return least_squared_distance(lower, upper, low, high); },
               [&](std::size_t k) {
                 // Two bounds, of which the larger counts: with a plane between them, and along the axes.
                 const double along = box_distance(tree_.item_lower(k), tree_.item_upper(k), low, high).lower;
                 if (along < least)
                   least = std::min(least, std::max(along, simplex(k).gap(center, half_widths)));
                 return least > 0.0 ? greatest_square(least) : -kInfinity;  // no box is nearer
               });
  return least;
}

}  // namespace s2nnds
