// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "s2nnds/problem/box_tree.h"

namespace s2nnds {

// A grid of cells over the box around a closed surface in space; of each cell that no item of the surface's tree
// meets, all of which lies on one side, it knows the side. Neighbours of that kind share it, so that few sides
// have to be found out. Sound: a point gets the side of its cell only if no item is near the cell, by far more
// than rounding.
class SideGrid {
 public:
  // `side` of a point: -1 inside, 1 outside, 0 not known. The tree's items hold the whole surface.
  SideGrid(const BoxTree& tree, const std::function<int(const Position&)>& side);

  // The side of x [3] within the tree's box; 0 where the grid does not know.
  int at(const Position& x) const;

 private:
  static constexpr Eigen::Index cells = 64;  // along each axis

  std::size_t place(const Eigen::Array3i& cell) const {
    return static_cast<std::size_t>((cell[0] * cells + cell[1]) * cells + cell[2]);
  }
  // The cell of x, by `beyond` cells farther in every direction.
  Eigen::Array3i cell_of(const Eigen::Vector3d& x, double beyond) const;
  void fill(const Eigen::Array3i& from, std::int8_t side);

  Eigen::Vector3d lower_, per_length_;  // the corner of the first cell; cells per length
  std::vector<std::int8_t> side_;
};

}  // namespace s2nnds
