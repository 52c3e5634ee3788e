// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/box_tree.h"

namespace s2nnds {

// Many points, segments or triangles with a tree over them. Distances to it are bounded in interval
// arithmetic.
class SimplexSet {
 public:
  // vertices [V, n]; simplices [S, k]: the rows of each one's vertices, k = 1, 2 or 3. Throws Error unless
  // S >= 1, all numbers are finite, every row exists and n <= most_coordinates.
  SimplexSet(Points vertices, Eigen::MatrixXi simplices);

  Eigen::Index dimension() const { return vertices_.cols(); }      // n
  const Points& vertices() const { return vertices_; }             // [V, n]
  const Eigen::MatrixXi& simplices() const { return simplices_; }  // [S, k]
  const BoxTree& tree() const { return tree_; }                    // whose items are the simplices
  Simplex simplex(std::size_t k) const;                            // the k-th, k < S
  Interval distance(const Position& x) const;                      // holds the exact distance of x [n]
  double rounded_distance(const Position& x) const;                // the same as one number, up to rounding
  double gap(const Box& box) const;  // at most the exact distance of a finite box

 private:
  Points vertices_;
  Eigen::MatrixXi simplices_;
  BoxTree tree_;
};

}  // namespace s2nnds
