#pragma once

#include <vector>

#include "s2nnds/core/points.h"

namespace s2nnds {

// The axis-aligned box lower <= x <= upper in R^n. Sides may be infinite.
struct Box {
  Vector lower;  // [n]
  Vector upper;  // [n]

  static Box cube(Eigen::Index dimension, double half_width);  // [-half_width, half_width]^n

  Eigen::Index dimension() const { return lower.size(); }
  bool contains(const Eigen::Ref<const Vector>& x) const;
  Vector center() const;
  Vector half_widths() const;
  double volume() const;
  bool is_empty() const;              // some lower > upper (or NaN)
  Box intersection(const Box& other) const;
  Eigen::Index widest_side() const;
  std::pair<Box, Box> bisect(Eigen::Index axis) const;
};

}  // namespace s2nnds
