// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/evaluation/rollout.h"

namespace s2nnds {

// Options of measure_robustness(). Lengths are in normalised units.
struct RobustnessOptions {
  // Starts along each side of a grid over the workspace, >= 1 (at most 8 in 3-D; 400 Sobol points in more
  // dimensions).
  int grid = 20;
  int repetitions = 10;       // perturbed starts, and pushes, of each demonstration's first point, >= 0
  double perturbation = 0.1;  // standard deviation, per axis, of what is added to a start, >= 0
  double push = 0.1;          // length of the displacement in mid-motion, in a random direction, >= 0
  // Points of Xu's boundary that distances are measured to, >= 1 (8 times as many in 3-D).
  std::int64_t boundary_samples = 4000;
  RolloutOptions rollout = {};  // how motions are followed
};

// How a set of motions ended. A motion is safe if it neither touches Xu nor leaves X, as far as it can be
// followed. Normalised units; shares are in [0, 1].
struct MotionOutcomes {
  std::string starts;        // "grid", "perturbed", "pushed"
  std::int64_t motions = 0;  // how many were followed
  double converged = 0.0;    // share that reaches the goal and is safe on its way
  double safe = 0.0;         // share that is safe
  // Number of motions that a certificate of f and B speaks of: they start in {B <= 0}, and the displacement,
  // if any, ends there. 0 without a B.
  std::int64_t covered = 0;
  double covered_converged = 0.0;  // share of these that converges, NaN if there are none
  double closest = 0.0;            // least distance of a safe motion to Xu, NaN if none is safe
  double mean_closest = 0.0;       // mean over the safe motions of their least distances
  double time_to_goal = 0.0;       // median over those that converge, NaN if none does
};

// Follows f from three sets of starts, in this order:
// - "grid": a grid over the workspace, without the points in Xu;
// - "perturbed": starts near the demonstrations' first points;
// - "pushed": those first points, with a sudden displacement after half the time to the goal (none if the
//   motion does not reach the goal without it). A displacement that ends in Xu or outside X is unsafe.
// The latter two are left out if there are no demonstrations. As in roll_out, a motion that enters the
// workspace margin has left X. Distances are to samples of Xu's boundary, so they are too large by at most
// the largest gap between samples; NaN without an obstacle. Random numbers: streams "robustness/..." of
// `seed`. B: the barrier function that f was certified with, if any.
std::vector<MotionOutcomes> measure_robustness(const StateFunction& f, const std::optional<StateFunction>& B,
                                               const SafetyProblem& problem,
                                               const std::vector<Demonstration>& demonstrations,
                                               std::uint64_t seed, const RobustnessOptions& options = {});

}  // namespace s2nnds
