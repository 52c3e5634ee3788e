// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/core/points.h"

namespace s2nnds {

// A parabola fitted by least squares to the samples around a time, on the times as they are (Savitzky and
// Golay 1964, here on grids that need not be even).
struct LocalParabola {
  Eigen::RowVectorXd value;  // [n] at that time
  Eigen::RowVectorXd slope;  // [n] derivative there
  // Weight of the sample nearest to that time in `value`, in (0, 1]: a residual there has the variance
  // noise^2 (1 - leverage).
  double leverage = 1;
};

// Fits to samples first .. first + count - 1, at least 3. time [M] increasing, position [M, n].
LocalParabola fit_parabola(const Vector& time, const Points& position, Eigen::Index first, Eigen::Index count,
                           double at);

// What a fit around every sample gives.
struct SmoothDerivative {
  Points velocity;   // [M, n]
  double noise = 0;  // standard deviation of a coordinate about the parabolas; 0 for windows of three samples
};

// Each sample's window reaches width/2 to both sides, has at least 5 samples, and at most a tenth of all but
// never fewer than 5; at the ends the window is cut where the data end and the sample is not in its middle.
// Where a window would have more than 32 samples, means of neighbours take their place. Fewer than 5 samples: the
// derivative of differentiate(), noise 0. time [M] increasing, position [M, n],
// M >= 2, width > 0 in the unit of time.
SmoothDerivative smooth_derivative(const Vector& time, const Points& position, double width);

}  // namespace s2nnds
