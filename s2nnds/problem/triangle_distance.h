// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "s2nnds/core/points.h"

namespace s2nnds {

// The distance of points from many triangles in space, up to rounding, for levels at the many points of training.
// Proofs use enclosures (simplex_set.h) instead. Constant once built.
class TriangleDistance {
 public:
  // vertices [V, 3] finite; triangles [T, 3]: rows of `vertices`, T >= 1.
  TriangleDistance(const Points& vertices, const Eigen::MatrixXi& triangles);

  double operator()(const Eigen::Vector3d& x) const;  // of x, all numbers finite

 private:
  struct Triangle {
    Eigen::Vector3d corner, first, second;  // a corner, and the sides that leave it
    double squared_distance(const Eigen::Vector3d& x) const;
  };
  struct Node {
    Eigen::Vector3d lower, upper;
    std::size_t first = 0, last = 0;  // its triangles, if it has no children
    std::size_t child = 0;            // the first of two; 0: none
    double squared_distance(const Eigen::Vector3d& x) const {
      return (lower - x).cwiseMax(x - upper).cwiseMax(0.0).squaredNorm();
    }
  };
  void build(std::size_t node, std::size_t first, std::size_t last);

  std::vector<Triangle> triangles_;  // in the order of the nodes
  std::vector<Node> nodes_;
};

}  // namespace s2nnds
