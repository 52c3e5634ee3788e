// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/evaluation/rollout.h"

namespace s2nnds {

// The mean of |f(x) - xdot|^2, normalised units. `predicted` is f at the demonstrations' positions [N, n],
// `velocity` what was recorded there [N, n], N >= 1; throws Error on other shapes.
double mean_squared_error(const Points& predicted, const Points& velocity);
// The standard deviation of |f(x) - xdot|, of the same.
double error_deviation(const Points& predicted, const Points& velocity);

// Distance of two curves [M, n] and [K, n], M, K >= 1, by dynamic time warping: the least sum of Euclidean
// distances along a warping path (see warp), divided by that path's number of pairs. NaN if a curve is not
// finite. Throws Error on different dimensions.
double dtw(const Points& a, const Points& b);
// Distance of the same curves with a warping path for each axis: the square root of the sum over axes of that
// axis's least sum of squared differences.
double dtw_independent(const Points& a, const Points& b);

// How far f and its motions are from the demonstrations. Normalised units; NaN without demonstrations.
struct MotionErrors {
  double mse = 0.0;              // mean_squared_error over all samples
  double sd = 0.0;               // error_deviation over all samples
  double dtw = 0.0;              // dtw, mean over the demonstrations
  double dtw_independent = 0.0;  // dtw_independent, mean over the demonstrations
};
// Velocity errors at the samples; DTW of the rollout from each demonstration's first point at its times. Both of the
// first `places` coordinates alone, 0: of all.
MotionErrors motion_errors(const StateFunction& f, const std::vector<Demonstration>& demonstrations,
                           const RolloutOptions& options = {}, Eigen::Index places = 0);

}  // namespace s2nnds
