#pragma once

#include <vector>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/evaluation/rollout.h"

namespace s2nnds {

// All in normalised units; `predicted` = f at the demonstrations' positions, [N, n].
double mean_squared_error(const Points& predicted, const Points& velocity);  // mean |f(x) - xdot|^2
double error_deviation(const Points& predicted,
                       const Points& velocity);  // standard deviation of |f(x) - xdot|

// Dynamic time warping of two curves [M, n] and [K, n], M, K >= 1; paths advance by (1, 0), (0, 1) or (1, 1).
// Throws Error on different dimensions. Dependent: the least sum of Euclidean distances along a path, divided
// by that path's number of pairs (the shortest such path, if several have this sum).
double dtw(const Points& a, const Points& b);
// sqrt(sum over axes of the axis's own least sum of squared differences).
double dtw_independent(const Points& a, const Points& b);

struct MotionErrors {
  double mse = 0.0;
  double sd = 0.0;
  double dtw = 0.0;  // mean over demonstrations, NaN if there are none
  double dtw_independent = 0.0;
};
// Velocity errors at the samples; DTW of the rollout from each demonstration's first point at its time
// stamps.
MotionErrors motion_errors(const NetworkWeights& f, const std::vector<Demonstration>& demonstrations,
                           const RolloutOptions& options = {});

}  // namespace s2nnds
