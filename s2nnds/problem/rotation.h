// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/problem/interval.h"

namespace s2nnds {

// A rotation in two or three dimensions, as what was given says exactly: an angle or a quaternion.
struct Rotation {
  Points matrix;                    // [n, n], rounded
  std::vector<Interval> enclosure;  // [n n], row by row: holds the exact matrix
  std::string text;                 // in words; empty: none
};

Rotation no_rotation(Eigen::Index dimension);  // n
// In 2-D by `radians`, from the first axis towards the second. Throws Error unless it is finite.
Rotation rotation_by_angle(double radians);
// In 3-D by the quaternion (x, y, z, w) of any length but 0, the order of ROS and SciPy, or by a rotation
// matrix of nine numbers, row by row, which becomes the quaternion nearest to it. Throws Error unless there
// are four or nine numbers and they are a rotation (a matrix to within 1e-6).
Rotation rotation_in_space(const std::vector<double>& numbers);

}  // namespace s2nnds
