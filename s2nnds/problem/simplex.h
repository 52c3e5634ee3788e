// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "s2nnds/core/points.h"
#include "s2nnds/problem/box.h"
#include "s2nnds/problem/interval.h"

namespace s2nnds {

// The largest dimension of the sets that are made of simplices or placed.
inline constexpr int most_coordinates = 16;
// One point [n], n <= most_coordinates, that needs no memory from the heap.
using Position = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, most_coordinates, 1>;

// The convex hull of one, two or three points: a point, a segment or a triangle.
struct Simplex {
  std::array<Position, 3> vertex;  // each [n]
  int count = 0;                   // how many vertices there are, 1 to 3

  // Holds the exact distance of x [n], all numbers finite.
  Interval distance(const Position& x) const;
  double rounded_distance(const Position& x) const;  // the same as one number, up to rounding
  // At most the exact distance between the simplex and the box with this centre and these half widths [n].
  double gap(const Position& center, const Position& half_widths) const;
};

// At most and at least the exact distance between two boxes, given by their corners [n].
Interval box_distance(const Position& lower, const Position& upper, const Position& other_lower,
                      const Position& other_upper);

// The squared distance of two boxes, up to rounding; exactly 0 where they meet.
double rounded_squared_distance(const Position& lower, const Position& upper, const Position& other_lower,
                                const Position& other_upper);
// At most the exact squared distance of two boxes, and so near to it that a search that passes over what is
// farther passes over little less. Much quicker than box_distance().
double least_squared_distance(const Position& lower, const Position& upper, const Position& other_lower,
                              const Position& other_upper);
// At least the square of a distance >= 0, to compare with the above.
double greatest_square(double distance);

// At least the distance from the centre of a finite box, as Box::center() rounds it, to its farthest point.
double half_diagonal(const Box& box);

// The enclosure over a box of a function that is 1-Lipschitz, from that of its value at the box's centre.
Interval lipschitz_enclosure(const Interval& at_center, const Box& box);

}  // namespace s2nnds
