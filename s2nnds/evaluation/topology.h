// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "s2nnds/evaluation/state_function.h"
#include "s2nnds/problem/safety_problem.h"

namespace s2nnds {

// A part of {B > 0} inside the workspace that does not reach its edge.
struct Island {
  Vector place;         // [n] the middle of one of its cells
  double volume = 0.0;  // normalised
  bool holds_obstacle = false;
};

// A part of {B <= 0} that does not reach the goal.
struct Fragment {
  Vector place;         // [n] the middle of one of its cells
  double volume = 0.0;  // normalised
};

// A place other than the goal where f(x) = 0.
struct Equilibrium {
  Vector place;  // [n]
  std::int64_t index =
      0;  // sign of det Jf: 1 (a source, sink or centre), -1 (a saddle), 0 (neither is certain)
  bool in_obstacle = false;  // the place is in the unsafe set
};

// What no certificate can have. {B <= 0} is compact and invariant and all its motions converge to one point, so it
// is contractible: in one piece, and every part of {B > 0} reaches the workspace's edge. V falls along every motion, so f
// vanishes at the goal alone.
struct Topology {
  std::vector<Island> islands;          // the largest first
  std::vector<Fragment> fragments;      // the largest first
  std::vector<Equilibrium> equilibria;  // in no order
  bool is_possible() const { return islands.empty() && fragments.empty() && equilibria.empty(); }
};

// Looks on a grid, 121 cells a side in two dimensions and 41 in three; nothing is found in more. Islands smaller
// than three cells are not reported; fragments in two dimensions only, where more than a cell's width separates them from
// the rest, since a grid does not see narrow straits; equilibria are sought by Newton's method from the places where |f| is least
// among their neighbours, and reported beyond 0.03 (normalised) from the goal. It is a search: what it does
// not find may still be there.
Topology find_topology(const StateFunction& f, const StateFunction& B, const SafetyProblem& problem);

}  // namespace s2nnds
