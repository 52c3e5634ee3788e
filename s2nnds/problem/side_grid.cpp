// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/side_grid.h"

namespace s2nnds {
namespace {

// Of a cell: how far items are kept from cells whose side is known. Rounding moves points by some 1e-14 cells.
constexpr double kMargin = 1e-6;
constexpr std::int8_t kMet = 2,
                      kNotSeen = 3;  // while the grid is made; then 0 stands for the cells that are met

}  // namespace

SideGrid::SideGrid(const BoxTree& tree, const std::function<int(const Position&)>& side)
    : lower_(tree.lower()), side_(static_cast<std::size_t>(cells * cells * cells), kNotSeen) {
  const Eigen::Vector3d size = Eigen::Vector3d(tree.upper()) - lower_;
  // A surface without extent along an axis holds nothing; one cell of any size does for it.
  const double least = 1e-9 * size.maxCoeff();
  per_length_ = static_cast<double>(cells) / size.array().max(least > 0 ? least : 1.0);
  tree.visit([](const Position&, const Position&) { return true; },
             [&](std::size_t k) {
               const Eigen::Array3i first = cell_of(tree.item_lower(k), -kMargin),
                                    last = cell_of(tree.item_upper(k), kMargin);
               for (int i = first[0]; i <= last[0]; ++i)
                 for (int j = first[1]; j <= last[1]; ++j)
                   for (int l = first[2]; l <= last[2]; ++l) side_[place({i, j, l})] = kMet;
               return true;
             });
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      for (int l = 0; l < cells; ++l) {
        const Eigen::Array3i cell{i, j, l};
        if (side_[place(cell)] != kNotSeen) continue;
        const Eigen::Vector3d middle = lower_.array() + (cell.cast<double>() + 0.5) / per_length_.array();
        fill(cell, static_cast<std::int8_t>(side(middle)));
      }
    }
  }
  for (std::int8_t& known : side_)
    if (known == kMet) known = 0;
}

Eigen::Array3i SideGrid::cell_of(const Eigen::Vector3d& x, double beyond) const {
  const Eigen::Array3d place = (x - lower_).array() * per_length_.array() + beyond;
  return place.max(0.0).min(static_cast<double>(cells - 1)).floor().cast<int>();
}

// Gives the side to all cells that hang together with this one by faces.
void SideGrid::fill(const Eigen::Array3i& from, std::int8_t side) {
  std::vector<Eigen::Array3i> open{from};
  side_[place(from)] = side;
  while (!open.empty()) {
    const Eigen::Array3i cell = open.back();
    open.pop_back();
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        Eigen::Array3i next = cell;
        next[axis] += step;
        if (next[axis] < 0 || next[axis] >= cells || side_[place(next)] != kNotSeen) continue;
        side_[place(next)] = side;
        open.push_back(next);
      }
    }
  }
}

int SideGrid::at(const Position& x) const { return side_[place(cell_of(Eigen::Vector3d(x), 0.0))]; }

}  // namespace s2nnds
