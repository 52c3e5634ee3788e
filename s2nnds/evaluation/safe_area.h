// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/evaluation/rollout.h"

namespace s2nnds {

// Areas within X (volumes in 3-D), in normalised units; where the state has a phase, of the places from which a motion
// starts with the phase's start.
struct SafeArea {
  double safe_area = 0.0;       // of {B <= 0}
  double true_safe_area = 0.0;  // of the points whose rollout is safe and reaches the goal
  // How much of the true area B calls safe; NaN if both are 0.
  double ratio() const { return safe_area / true_safe_area; }
};

// On a grid of cell centres, `cells` along each side (0: 200 in 2-D, 40 in 3-D); in more dimensions on that
// many Sobol points in all (0: 40,000). The true area follows each point's motion with rollout_is_safe.
SafeArea measure_safe_area(const StateFunction& f, const StateFunction& B, const SafetyProblem& problem,
                           int cells = 0, const BatchRolloutOptions& options = {});

// The area of {B <= 0} alone within any finite box, on such a grid.
double sublevel_area(const StateFunction& B, const Box& within, int cells);

// The points of such a grid, each of which stands for an equal share of the box: [cells^n, n], the last axis
// running fastest, or [cells, n] in more than three dimensions.
Points evaluation_points(const Box& within, int cells);

}  // namespace s2nnds
