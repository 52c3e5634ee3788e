// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "s2nnds/core/points.h"

namespace s2nnds {

// The axis-aligned box lower <= x <= upper in R^n. Sides may be infinite.
struct Box {
  Vector lower;  // [n]
  Vector upper;  // [n]

  static Box cube(Eigen::Index dimension, double half_width);  // [-half_width, half_width]^n

  Eigen::Index dimension() const { return lower.size(); }  // n
  bool contains(const Eigen::Ref<const Vector>& x) const;  // false for NaN and for another dimension
  // The side's midpoint: not a number where both ends are infinite.
  Vector center() const;
  // Rounded up, so that center() -+ half_widths() encloses the box in exact arithmetic.
  Vector half_widths() const;
  double volume() const;   // 0 if empty
  bool is_empty() const;   // some lower > upper (or NaN), or sides that do not match
  bool is_finite() const;  // no bound is infinite or NaN
  // The common part, which may be empty. Throws Error on another dimension.
  Box intersection(const Box& other) const;
  Eigen::Index widest_side() const;  // its axis, from 0; n > 0
  // The lower and the upper half along `axis`; both hold their common face. Throws Error unless that side is
  // finite.
  std::pair<Box, Box> bisect(Eigen::Index axis) const;
};

}  // namespace s2nnds
