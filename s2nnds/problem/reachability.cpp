// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/reachability.h"

#include <vector>

#include "s2nnds/problem/cell_grid.h"

namespace s2nnds {

std::optional<Reachability> find_reachability(const SafetyProblem& problem, const Points& starts) {
  const Eigen::Index n = problem.dimension();
  if (n > 3) return std::nullopt;
  Reachability found{.cells = n == 2 ? 301 : 61, .place = {}};
  const CellGrid grid(problem.workspace, found.cells);
  const Points middles = grid.middles();
  const Vector unsafe = problem.unsafe->level(middles), initial = problem.initial->level(middles);
  std::vector<bool> free(static_cast<std::size_t>(grid.size()));
  for (Eigen::Index k = 0; k < grid.size(); ++k) free[static_cast<std::size_t>(k)] = !(unsafe[k] <= 0.0);
  std::vector<bool> reached(free.size(), false);
  flood(grid, free, {grid.cell_of(Vector::Zero(n))}, reached);

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
