// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/evaluation/rollout.h"

namespace s2nnds {

// All in normalised units. `predicted` = f at the demonstrations' positions [N, n], `velocity` as recorded
// there [N, n], N >= 1; throw Error on other shapes.
double mean_squared_error(const Points& predicted, const Points& velocity);  // mean of |f(x) - xdot|^2
double error_deviation(const Points& predicted,
                       const Points& velocity);  // standard deviation of |f(x) - xdot|

// Distance of two curves [M, n] and [K, n], M, K >= 1, by dynamic time warping: the least sum of Euclidean
// distances along a warping path (see warp), divided by that path's number of pairs. NaN if a curve is not
// finite. Throws Error on different dimensions.
double dtw(const Points& a, const Points& b);
// sqrt(sum over axes of the axis's own least sum of squared differences).
double dtw_independent(const Points& a, const Points& b);

struct MotionErrors {
  double mse = 0.0;
  double sd = 0.0;
  double dtw = 0.0;  // mean over demonstrations, NaN if there are none
  double dtw_independent = 0.0;
};
// Velocity errors at the samples; DTW of the rollout from each demonstration's first point at its times.
MotionErrors motion_errors(const StateFunction& f, const std::vector<Demonstration>& demonstrations,
                           const RolloutOptions& options = {});

}  // namespace s2nnds
