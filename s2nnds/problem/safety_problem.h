// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/core/options.h"
#include "s2nnds/data/demonstration.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {

// What a motion must satisfy, in normalised, goal-centred coordinates (the goal is the origin).
struct SafetyProblem {
  Box workspace;      // X, outside of which nothing is claimed
  RegionPtr initial;  // X0, where motions start
  RegionPtr unsafe;   // Xu, the obstacle
  // {x : |x|_inf >= containment * workspace}, closed: entering it counts as leaving the workspace. Null if
  // the safe set need not be contained.
  RegionPtr workspace_margin;

  Eigen::Index dimension() const { return workspace.dimension(); }  // n
};

// What make_problem() builds the sets from, in normalised coordinates.
struct ProblemOptions {
  double workspace = 1.25;     // X = [-workspace, workspace]^n, workspace > 0
  double containment = 0.985;  // in [0, 1): the safe set must lie in containment * X; 0: anywhere
  double padding = 0.02;       // >= 0: X0 of type "auto" is grown by this on every side
  // "auto": the box around the demonstrations' first points, grown by `padding`, clipped to [-1, 1]^n;
  // "ball_auto": the ball of `radius` around their mean; or any region.
  RegionOptions initial = {.type = "auto"};
  RegionOptions unsafe = {};  // Xu: any region; "none": no obstacle

  void visit(FieldVisitor& v);  // names every key
};

// Builds the sets and checks them. Throws Error, naming the place, when
// - options are out of range, or a region is not well written or not defined somewhere in the workspace (X0:
//   in twice the workspace),
// - a demonstration leaves the workspace,
// - the obstacle covers the goal, or is not "none" but has no points in the workspace,
// - X0 has no volume, or a point of it was found that is outside of containment * X or in the obstacle.
// The last three search with pavings and samples: an error names a point, but its absence proves nothing.
// Demonstrations may pass through the obstacle. `demonstrations` are normalised. `files` has what regions name
// as `file`.
SafetyProblem make_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                           RegionFiles& files);
// The same where no region needs a file that must be kept.
SafetyProblem make_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations);

}  // namespace s2nnds
