// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/data/demonstration.h"
#include "s2nnds/problem/region.h"
#include "s2nnds/problem/tool_sweep.h"

namespace s2nnds {

struct Frame;

// What a motion must satisfy, in normalised, goal-centred coordinates (the goal is the origin).
struct SafetyProblem {
  Box workspace;  // X, outside of which nothing is claimed; the goal lies inside, not always in the middle
  RegionPtr initial;  // X0, where motions start
  RegionPtr unsafe;   // Xu, the obstacle
  // What lies outside of containment * X, closed: entering it counts as leaving the workspace. Null if the safe
  // set need not be contained.
  RegionPtr workspace_margin;
  Box contained;  // the part of X that the safe set must lie in; X itself where that is not asked
  // X0 and Xu as one would write them in the unit and frame of problem.frame, with nothing left to find out: what
  // make_region() makes of them are the sets above.
  RegionOptions written_initial, written_unsafe;
  // Where the last coordinate, a phase (data/phase.h), starts; 0: there is none. Xu holds whatever the phase is.
  double phase_start = 0.0;

  Eigen::Index dimension() const { return workspace.dimension(); }  // n
  bool has_phase() const { return phase_start > 0.0; }
  Eigen::Index places() const { return dimension() - (has_phase() ? 1 : 0); }  // coordinates of a place
};

// The workspace as a box of its own, in the unit and frame of problem.frame; without it, a cube.
struct BoundsOptions {
  std::vector<double> lower = {};  // the least coordinates, [n]; empty: problem.workspace says
  std::vector<double> upper = {};  // the greatest coordinates, [n]

  void visit(FieldVisitor& v);  // names both
};

// What make_problem() builds the sets from. Where the state has a phase s (data/phase.h), all are written in places
// alone: the obstacle is there whatever s is, X0 has s within 2 % of its start, and X reaches from -0.25 to 1.25 times
// that start.
struct ProblemOptions {
  // Whose unit and frame the sets below are written in: "data", positions as they are in the files (the
  // robot's), or "normalised", with the goal at the origin and the largest coordinate 1.
  std::string frame = "data";
  // > 0: X reaches this far from the goal on every side, as a multiple of the demonstrations' largest
  // coordinate seen from the goal (in every frame). bounds comes before it.
  double workspace = 1.25;
  BoundsOptions bounds = {};   // X as a box of its own; the goal must lie inside
  double containment = 0.985;  // in [0, 1): the safe set must lie in X shrunk by this; 0: anywhere
  // >= 0: X0 of type "auto" is grown by this on every side, as a share of the largest coordinate.
  double padding = 0.02;
  // "auto": the box around the demonstrations' first points, grown by `padding`, no larger than the largest
  // coordinate; a box for each group of them where groups lie a quarter of that apart; "ball_auto": the ball of `radius` around their mean; or any region.
  RegionOptions initial = {.type = "auto"};
  RegionOptions unsafe = {};  // Xu: any region; "none": no obstacle
  ToolOptions tool = {};      // of poses in 3-D, in frame "data": Xu grows by what it sweeps

  void visit(FieldVisitor& v);  // names every key
};

// Builds the sets and checks them. `demonstrations` are normalised, by `frame`. Throws Error, naming the place
// in the unit and frame of problem.frame, when
// - options are out of range, or a region is not well written or not defined somewhere in the workspace (X0:
//   in twice the workspace),
// - the goal lies outside of the bounds, or a demonstration leaves the workspace,
// - the obstacle covers the goal, or is not "none" but has no points in the workspace,
// - X0 has no volume, or a point of it was found that is outside of containment * X or in the obstacle.
// The last three search with pavings and samples: an error names a point, but its absence proves nothing.
// Demonstrations may pass through the obstacle. `files` has what regions name as `file`.
SafetyProblem make_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                           const Frame& frame, RegionFiles& files);
// The same sets without the checks of where they lie, to look at a problem that is wrong. Throws Error when a
// set cannot be made at all.
SafetyProblem draft_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                            const Frame& frame, RegionFiles& files);
// The same as make_problem where no region needs a file that must be kept.
SafetyProblem make_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                           const Frame& frame);

}  // namespace s2nnds
