#pragma once

#include "s2nnds/evaluation/rollout.h"

namespace s2nnds {

struct SafeArea {
  double safe_area = 0.0;       // of {B <= 0} within X (volume in 3-D), normalised units
  double true_safe_area = 0.0;  // of the points whose rollout is safe and reaches the goal
  double ratio() const { return safe_area / true_safe_area; }
};

// On a grid of cell centres, `cells` along each side (default: 200 in 2-D, 40 in 3-D, else Sobol points).
SafeArea measure_safe_area(const Networks& networks, const SafetyProblem& problem, int cells = 0);

// The area of {B <= 0} alone within any box.
double sublevel_area(const LayerStack& B, const Box& within, int cells);

}  // namespace s2nnds
