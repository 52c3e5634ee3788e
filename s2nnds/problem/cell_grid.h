// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/problem/box.h"

namespace s2nnds {

// A box cut into cells, `count` along each axis, numbered with the last axis running fastest.
class CellGrid {
 public:
  CellGrid(const Box& box, Eigen::Index count) : box_(box), count_(count) {}

  Eigen::Index size() const;                    // number of cells
  Points middles() const;                       // [size, n]
  double cell_volume() const;                   // of one cell
  bool is_at_edge(Eigen::Index cell) const;     // whether the cell touches the box's boundary
  Eigen::Index cell_of(const Vector& x) const;  // the cell that holds x [n], or the nearest one

  // Calls visit(neighbour) for the cells that share a face.
  template <typename Visit>
  void neighbours(Eigen::Index cell, const Visit& visit) const {
    Eigen::Index stride = 1;
    for (Eigen::Index i = 0; i < box_.dimension(); ++i, stride *= count_) {
      const Eigen::Index place = cell / stride % count_;
      if (place > 0) visit(cell - stride);
      if (place + 1 < count_) visit(cell + stride);
    }
  }

 private:
  Box box_;
  Eigen::Index count_;
};

// Marks in `reached` [size] the cells of `free` [size] that are joined with the cells `from`, which count as free.
void flood(const CellGrid& grid, const std::vector<bool>& free, std::vector<Eigen::Index> from,
           std::vector<bool>& reached);

}  // namespace s2nnds
