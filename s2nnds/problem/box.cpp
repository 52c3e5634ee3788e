// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/box.h"

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/interval.h"

namespace s2nnds {

Box Box::cube(Eigen::Index dimension, double half_width) {
  return {Vector::Constant(dimension, -half_width), Vector::Constant(dimension, half_width)};
}

bool Box::contains(const Eigen::Ref<const Vector>& x) const {
  return x.size() == dimension() && (x.array() >= lower.array()).all() && (x.array() <= upper.array()).all();
}

Vector Box::center() const { return 0.5 * lower + 0.5 * upper; }

Vector Box::half_widths() const {
  const Vector middle = center();
  Vector result(dimension());
  for (Eigen::Index i = 0; i < dimension(); ++i) {
    const double reach = std::max(upper[i] - middle[i], middle[i] - lower[i]);
    result[i] = reach == 0.0 ? 0.0 : next_up(reach);
  }
  return result;
}

double Box::volume() const { return is_empty() ? 0.0 : (upper - lower).prod(); }

bool Box::is_empty() const { return lower.size() != upper.size() || !(lower.array() <= upper.array()).all(); }

bool Box::is_finite() const { return lower.allFinite() && upper.allFinite(); }

Box Box::intersection(const Box& other) const {
  check(other.dimension() == dimension(), "box: intersection of dimension {} with dimension {}", dimension(),
        other.dimension());
  return {lower.cwiseMax(other.lower), upper.cwiseMin(other.upper)};
}

Eigen::Index Box::widest_side() const {
  Eigen::Index axis = 0;
  (upper - lower).maxCoeff(&axis);
  return axis;
}

std::pair<Box, Box> Box::bisect(Eigen::Index axis) const {
  const double middle = 0.5 * lower[axis] + 0.5 * upper[axis];
  check(std::isfinite(lower[axis]) && std::isfinite(upper[axis]),
        "box: side {} is [{}, {}]; only finite sides can be bisected", axis, lower[axis], upper[axis]);
  std::pair<Box, Box> halves(*this, *this);
  halves.first.upper[axis] = middle;
  halves.second.lower[axis] = middle;
  return halves;
}

}  // namespace s2nnds
