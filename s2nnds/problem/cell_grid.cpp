// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/cell_grid.h"

#include <algorithm>
#include <cmath>

namespace s2nnds {

Eigen::Index CellGrid::size() const {
  Eigen::Index size = 1;
  for (Eigen::Index i = 0; i < box_.dimension(); ++i) size *= count_;
  return size;
}

Points CellGrid::middles() const {
  Points all(size(), box_.dimension());
  for (Eigen::Index cell = 0; cell < all.rows(); ++cell) {
    Eigen::Index rest = cell;
    for (Eigen::Index i = box_.dimension(); i-- > 0; rest /= count_) {
      const double share = (static_cast<double>(rest % count_) + 0.5) / static_cast<double>(count_);
      all(cell, i) = box_.lower[i] + share * (box_.upper[i] - box_.lower[i]);
    }
  }
  return all;
}

double CellGrid::cell_volume() const {
  return (box_.upper - box_.lower).prod() / static_cast<double>(size());
}

bool CellGrid::is_at_edge(Eigen::Index cell) const {
  for (Eigen::Index i = 0; i < box_.dimension(); ++i, cell /= count_) {
    const Eigen::Index place = cell % count_;
    if (place == 0 || place + 1 == count_) return true;
  }
  return false;
}

Eigen::Index CellGrid::cell_of(const Vector& x) const {
  Eigen::Index cell = 0;
  for (Eigen::Index i = 0; i < box_.dimension(); ++i) {
    const double share = (x[i] - box_.lower[i]) / (box_.upper[i] - box_.lower[i]);
    const auto place = static_cast<Eigen::Index>(std::floor(share * static_cast<double>(count_)));
    cell = cell * count_ + std::clamp<Eigen::Index>(place, 0, count_ - 1);
  }
  return cell;
}

void flood(const CellGrid& grid, const std::vector<bool>& free, std::vector<Eigen::Index> from,
           std::vector<bool>& reached) {
  for (const Eigen::Index cell : from) reached[static_cast<std::size_t>(cell)] = true;
  while (!from.empty()) {
    const Eigen::Index cell = from.back();
    from.pop_back();
    grid.neighbours(cell, [&](Eigen::Index next) {
      const auto k = static_cast<std::size_t>(next);
      if (!free[k] || reached[k]) return;
      reached[k] = true;
      from.push_back(next);
    });
  }
}

}  // namespace s2nnds
