// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/triangle_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr std::size_t kMostTriangles = 4;  // of a node without children

// a / b where b > 0; triangles without area have others.
double share(double a, double b) { return b > 0 ? a / b : 0.0; }

}  // namespace

// The nearest point lies on the corner, the side or the face in whose Voronoi region x is (Ericson, Real-Time
// Collision Detection, 2005, section 5.1.5).
double TriangleDistance::Triangle::squared_distance(const Eigen::Vector3d& x) const {
  const Eigen::Vector3d d = x - corner;
  const double first_a = first.dot(d), second_a = second.dot(d);
  if (first_a <= 0 && second_a <= 0) return d.squaredNorm();
  const double ff = first.squaredNorm(), fs = first.dot(second), ss = second.squaredNorm();
  const double first_b = first_a - ff,
               second_b = second_a - fs;  // seen from the corner at the end of `first`
  if (first_b >= 0 && second_b <= first_b) return (d - first).squaredNorm();
  const double on_first = first_a * second_b - first_b * second_a;
  if (on_first <= 0 && first_a >= 0 && first_b <= 0)
    return (d - share(first_a, first_a - first_b) * first).squaredNorm();
  const double first_c = first_a - fs, second_c = second_a - ss;  // from the one at the end of `second`
  if (second_c >= 0 && first_c <= second_c) return (d - second).squaredNorm();
  const double on_second = first_c * second_a - first_a * second_c;
  if (on_second <= 0 && second_a >= 0 && second_c <= 0)
    return (d - share(second_a, second_a - second_c) * second).squaredNorm();
  const double on_third = first_b * second_c - first_c * second_b;
  const double along = second_b - first_b, back = first_c - second_c;
  if (on_third <= 0 && along >= 0 && back >= 0)
    return (d - first - share(along, along + back) * (second - first)).squaredNorm();
  const double whole = on_first + on_second + on_third;
  return (d - share(on_second, whole) * first - share(on_first, whole) * second).squaredNorm();
}

TriangleDistance::TriangleDistance(const Points& vertices, const Eigen::MatrixXi& triangles) {
  check(vertices.cols() == 3 && triangles.cols() == 3 && triangles.rows() >= 1,
        "triangle distance: found vertices [{}, {}] and triangles [{}, {}]; expected [V, 3] and [T, 3]",
        vertices.rows(), vertices.cols(), triangles.rows(), triangles.cols());
  for (Eigen::Index k = 0; k < triangles.rows(); ++k) {
    const Eigen::Vector3d a = vertices.row(triangles(k, 0)), b = vertices.row(triangles(k, 1)),
                          c = vertices.row(triangles(k, 2));
    triangles_.push_back({a, b - a, c - a});
  }
  nodes_.reserve(triangles_.size());
  nodes_.emplace_back();
  build(0, 0, triangles_.size());
}

// Halves the triangles at the median of their middles along the axis in which these spread the most.
void TriangleDistance::build(std::size_t node, std::size_t first, std::size_t last) {
  const auto middle_of = [](const Triangle& t) -> Eigen::Vector3d {
    return t.corner + (t.first + t.second) / 3;
  };
  Eigen::Vector3d lower = triangles_[first].corner, upper = lower;
  Eigen::Vector3d least = middle_of(triangles_[first]), greatest = least;
  for (std::size_t k = first; k < last; ++k) {
    const Triangle& t = triangles_[k];
    for (const Eigen::Vector3d& at :
         {t.corner, Eigen::Vector3d(t.corner + t.first), Eigen::Vector3d(t.corner + t.second)}) {
      lower = lower.cwiseMin(at);
      upper = upper.cwiseMax(at);
    }
    least = least.cwiseMin(middle_of(t));
    greatest = greatest.cwiseMax(middle_of(t));
  }
  nodes_[node] = {lower, upper, first, last, 0};
  if (last - first <= kMostTriangles) return;
  Eigen::Index axis = 0;
  (greatest - least).maxCoeff(&axis);
  const std::size_t half = first + (last - first) / 2;
  const auto at = [&](std::size_t k) { return triangles_.begin() + static_cast<std::ptrdiff_t>(k); };
  std::nth_element(at(first), at(half), at(last), [&](const Triangle& a, const Triangle& b) {
    return middle_of(a)[axis] < middle_of(b)[axis];
  });
  const std::size_t child = nodes_.size();
  nodes_[node].child = child;
  nodes_.resize(child + 2);
  build(child, first, half);
  build(child + 1, half, last);
}

double TriangleDistance::operator()(const Eigen::Vector3d& x) const {
  struct Open {
    double least;
    std::size_t node;
  };
  // Every step down halves the triangles and leaves one node aside, so that no more can be open at a time.
  std::array<Open, 66> open;
  std::size_t count = 0;
  open[count++] = {0.0, 0};
  double nearest = std::numeric_limits<double>::infinity();
  while (count > 0) {
    const auto [least, index] = open[--count];
    if (!(least < nearest)) continue;
    const Node& node = nodes_[index];
    if (node.child == 0) {
      for (std::size_t k = node.first; k < node.last; ++k)
        nearest = std::min(nearest, triangles_[k].squared_distance(x));
      continue;
    }
    Open near{nodes_[node.child].squared_distance(x), node.child};
    Open far{nodes_[node.child + 1].squared_distance(x), node.child + 1};
    if (far.least < near.least) std::swap(near, far);
    if (far.least < nearest) open[count++] = far;
    if (near.least < nearest) open[count++] = near;
  }
  return std::sqrt(nearest);
}

}  // namespace s2nnds
