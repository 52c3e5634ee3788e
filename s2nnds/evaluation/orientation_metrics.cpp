// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/orientation_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "s2nnds/core/dynamic_time_warping.h"
#include "s2nnds/data/orientation.h"

namespace s2nnds {

Vector matched_angles(const Points& a, const Points& b) {
  Points cost(a.rows(), b.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < b.rows(); ++j)
      cost(i, j) = angle_between(a.row(i).transpose(), b.row(j).transpose());
  const WarpingPath path = warp(cost);
  Vector angles(static_cast<Eigen::Index>(path.pairs.size()));
  for (std::size_t k = 0; k < path.pairs.size(); ++k)
    angles[static_cast<Eigen::Index>(k)] = cost(path.pairs[k].first, path.pairs[k].second);
  return angles;
}

OrientationErrors orientation_errors(const StateFunction& f, const OrientationLaw& law, const Frame& frame,
                                     const std::vector<Demonstration>& demonstrations,
                                     const RolloutOptions& options) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (demonstrations.empty()) return {nan, nan};
  OrientationErrors errors;
  for (const Demonstration& shown : demonstrations) {
    const Vector times = shown.time.array() - shown.time[0];
    const Points rolled = roll_out_at(f, shown.position.row(0).transpose(), times, options);
    if (!rolled.allFinite()) return {nan, nan};
    const Eigen::Vector4d start = shown.orientation.row(0).transpose();
    const Points turned = law.follow(frame.goal_orientation, frame.time_scale() * times, rolled, start);
    const Vector angles = matched_angles(turned, shown.orientation);
    errors.mean += angles.mean() / static_cast<double>(demonstrations.size());
    errors.largest = std::max(errors.largest, angles.maxCoeff());
  }
  return errors;
}

}  // namespace s2nnds
