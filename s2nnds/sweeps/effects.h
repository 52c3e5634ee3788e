#pragma once

#include <string>
#include <vector>

#include "s2nnds/sweeps/sweep.h"
#include "s2nnds/sweeps/trial_result.h"

namespace s2nnds {

// What one axis does to one figure of a run, all other axes as they are.
struct Effect {
  double change = 0.0;  // a factor, or a difference; NaN when it cannot be told
  double error = 0.0;   // its standard error
};

// From the low end of a range to its high end, or from a list's first value to another one.
struct AxisEffect {
  std::string axis, from, to;
  std::vector<Effect> on;  // in the order of EffectTable::figures
};

struct EffectFigure {
  std::string name;     // a metric of the runs, or "counts"
  bool factor = false;  // the change is a factor: the figure is positive, and compared by its logarithm
  std::int64_t trials = 0;
  bool told = false;  // whether the trials differ, and tell the axes' effects apart
};

struct EffectTable {
  std::vector<EffectFigure> figures;
  std::vector<AxisEffect> rows;
};

// Least squares over the trials of a rung: figure (or its logarithm) = a constant of the problem + for each
// axis a slope over its range, in the axis's own scale, or a constant of each value of its list. "counts" is
// of all trials, the metrics are of those that count: the objective, safe_area_ratio and seconds. The errors
// assume that what the model leaves out is independent from trial to trial, as it is when the sweep is not
// crossed; the runs of one point share what axes do together.
EffectTable estimate_effects(const Sweep& sweep, const std::vector<TrialResult>& results);

}  // namespace s2nnds
