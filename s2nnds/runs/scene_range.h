// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "s2nnds/problem/displacement.h"
#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

// What a range is looked for.
struct SceneRangeOptions {
  // The one of a union of obstacles that is displaced, from 0 in the order of problem.unsafe.of; none: all of them, as one
  std::optional<std::int64_t> obstacle = std::nullopt;
  // In (0, 0.95]: space is stretched and squeezed by factors of 1 + stretch and 1 - stretch at most
  double stretch = 0.8;
  double radius = 0.0;     // > 0: no longer displacements are wanted, normalised
  Vector half_sizes = {};  // [places] > 0, normalised: none outside of this box; empty: any
};

// Displacements p of an obstacle for which a certificate holds by construction: those within a ball, and a box if one was
// asked for. Normalised units, positions seen from the goal. Why it does: verification/README.md.
struct SceneRange {
  std::string obstacle = {};  // what is displaced, in words
  std::int64_t index = -1;    // of SceneRangeOptions::obstacle; -1: all
  Displacement displacement;  // T_p
  double radius = 0.0;        // |p| <= radius
  Vector half_sizes = {};     // [places]: |p_i| <= half_sizes_i; empty: none
  std::string limit = {};     // what lies at the edge of the ball that changes, in words
  double stretch = 0.0;       // above |p| Lip(psi) of every p: no velocity grows by more than this share
  // Motions of f_p + w stay in {B_p <= 0} for every |w| <= this and every p (normalised velocity); 0: not certified.
  double margin = 0.0;

  bool holds(const Vector& p) const;  // whether p [places] belongs to it; false for NaN
  // Some displacements at its edge, [N, places]: in the plane `count` directions, else along the axes and the diagonals.
  Points ends(int count = 8) const;
};

// The largest such range of a run whose guarantee is `invariant`, alone by where the sets lie: nothing is trained or
// proved again. Throws Error in one line for other guarantees, obstacles that are not bounded or no place of the state, and
// where the goal, X0, the workspace or another obstacle leaves no room.
SceneRange scene_range(const PreparedRun& setup, const RunRecord& record,
                       const SceneRangeOptions& options = {});

// The scene with the obstacle displaced by p [places]. `setup` is what the range was made from.
SafetyProblem moved_problem(const PreparedRun& setup, const SceneRange& range, const Vector& p);

// What is certified, in some sentences with units.
std::string range_statement(const RunRecord& record, const SceneRange& range);

}  // namespace s2nnds
