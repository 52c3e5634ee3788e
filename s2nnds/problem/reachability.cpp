// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/reachability.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace s2nnds {
namespace {

// A box cut into cells, `count` along each axis, numbered with the last axis running fastest.
class CellGrid {
 public:
  CellGrid(const Box& box, Eigen::Index count) : box_(box), count_(count) {}

  Eigen::Index size() const {
    Eigen::Index size = 1;
    for (Eigen::Index i = 0; i < box_.dimension(); ++i) size *= count_;
    return size;
  }
  // [size, n]
  Points middles() const {
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
  // The cell that holds x, or the nearest one.
  Eigen::Index cell_of(const Vector& x) const {
    Eigen::Index cell = 0;
    for (Eigen::Index i = 0; i < box_.dimension(); ++i) {
      const double share = (x[i] - box_.lower[i]) / (box_.upper[i] - box_.lower[i]);
      const auto place = static_cast<Eigen::Index>(std::floor(share * static_cast<double>(count_)));
      cell = cell * count_ + std::clamp<Eigen::Index>(place, 0, count_ - 1);
    }
    return cell;
  }
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

// The free cells that are connected with `from`.
std::vector<bool> flood(const CellGrid& grid, const std::vector<bool>& free, Eigen::Index from) {
  std::vector<bool> reached(free.size(), false);
  reached[static_cast<std::size_t>(from)] = true;
  for (std::vector<Eigen::Index> open = {from}; !open.empty();) {
    const Eigen::Index cell = open.back();
    open.pop_back();
    grid.neighbours(cell, [&](Eigen::Index next) {
      const auto k = static_cast<std::size_t>(next);
      if (!free[k] || reached[k]) return;
      reached[k] = true;
      open.push_back(next);
    });
  }
  return reached;
}

}  // namespace

std::optional<Reachability> find_reachability(const SafetyProblem& problem, const Points& starts) {
  const Eigen::Index n = problem.dimension();
  if (n > 3) return std::nullopt;
  Reachability found{.cells = n == 2 ? 301 : 61, .place = {}};
  const CellGrid grid(problem.workspace, found.cells);
  const Points middles = grid.middles();
  const Vector unsafe = problem.unsafe->level(middles), initial = problem.initial->level(middles);
  std::vector<bool> free(static_cast<std::size_t>(grid.size()));
  for (Eigen::Index k = 0; k < grid.size(); ++k) free[static_cast<std::size_t>(k)] = !(unsafe[k] <= 0.0);
  const std::vector<bool> reached = flood(grid, free, grid.cell_of(Vector::Zero(n)));

  Eigen::Index cells = 0, lost = 0;
  const auto count = [&](Eigen::Index cell, const Vector& place) {
    ++cells;
    if (reached[static_cast<std::size_t>(cell)]) return;
    if (lost++ == 0) found.place = place;
  };
  for (Eigen::Index k = 0; k < grid.size(); ++k) {
    if (initial[k] <= 0.0 && free[static_cast<std::size_t>(k)]) count(k, middles.row(k).transpose());
  }
  for (Eigen::Index k = 0; k < starts.rows(); ++k) {
    const Vector start = starts.row(k).transpose();
    const Eigen::Index cell = grid.cell_of(start);
    if (free[static_cast<std::size_t>(cell)]) count(cell, start);
  }
  found.cut_off = cells > 0 ? static_cast<double>(lost) / static_cast<double>(cells) : 0.0;
  found.goal_is_walled_in = cells > 0 && lost == cells;
  return found;
}

}  // namespace s2nnds
