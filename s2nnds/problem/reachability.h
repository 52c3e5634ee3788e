// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "s2nnds/problem/safety_problem.h"

namespace s2nnds {

// Which starts have a way to the goal around the obstacle, on a grid.
struct Reachability {
  Eigen::Index cells = 0;          // of the grid, along each axis
  bool goal_is_walled_in = false;  // no start has a way
  double cut_off = 0;              // share of the initial set's cells outside of the obstacle that have none
  Vector place;                    // [n] one of them; empty without any
};

// Floods the workspace from the goal, the origin, through cells whose middle is not in the obstacle: 301 cells a
// side in two dimensions, 61 in three; nothing in more. Starts are the cells whose middle is in the initial set,
// and the points `starts` [K, n]. A gap or a wall thinner than a cell may be missed.
std::optional<Reachability> find_reachability(const SafetyProblem& problem, const Points& starts);

}  // namespace s2nnds
