// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/trajectory_metrics.h"

#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/dynamic_time_warping.h"

namespace s2nnds {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

Vector error_norms(const Points& predicted, const Points& velocity) {
  check(predicted.rows() == velocity.rows() && predicted.cols() == velocity.cols() && predicted.rows() > 0,
        "velocity error: found predictions [{}, {}] for velocities [{}, {}], expected equal shapes and at "
        "least one row",
        predicted.rows(), predicted.cols(), velocity.rows(), velocity.cols());
  return (predicted - velocity).rowwise().norm();
}

void check_curves(const Points& a, const Points& b) {
  check(a.rows() > 0 && b.rows() > 0 && a.cols() == b.cols(),
        "dtw: found curves [{}, {}] and [{}, {}], expected at least one row each and equal dimensions",
        a.rows(), a.cols(), b.rows(), b.cols());
}

}  // namespace

double mean_squared_error(const Points& predicted, const Points& velocity) {
  return error_norms(predicted, velocity).squaredNorm() / static_cast<double>(velocity.rows());
}

double error_deviation(const Points& predicted, const Points& velocity) {
  const Vector norms = error_norms(predicted, velocity);
  return std::sqrt((norms.array() - norms.mean()).square().mean());
}

double dtw(const Points& a, const Points& b) {
  check_curves(a, b);
  if (!a.allFinite() || !b.allFinite()) return kNotANumber;
  Points distance(a.rows(), b.rows());
  for (Eigen::Index j = 0; j < b.rows(); ++j) distance.col(j) = (a.rowwise() - b.row(j)).rowwise().norm();
  const WarpingPath path = warp(distance);
  return path.cost / static_cast<double>(path.pairs.size());
}

double dtw_independent(const Points& a, const Points& b) {
  check_curves(a, b);
  if (!a.allFinite() || !b.allFinite()) return kNotANumber;
  double sum = 0.0;
  for (Eigen::Index k = 0; k < a.cols(); ++k) {
    Points squared(a.rows(), b.rows());
    for (Eigen::Index j = 0; j < b.rows(); ++j) squared.col(j) = (a.col(k).array() - b(j, k)).square();
    sum += warp(squared).cost;
  }
  return std::sqrt(sum);
}

MotionErrors motion_errors(const StateFunction& f, const std::vector<Demonstration>& demonstrations,
                           const RolloutOptions& options, Eigen::Index places) {
  if (demonstrations.empty()) return {kNotANumber, kNotANumber, kNotANumber, kNotANumber};
  const Eigen::Index judged = places > 0 ? places : demonstrations.front().dimension();
  const Points velocity = stack_velocities(demonstrations).leftCols(judged);
  const Points predicted = f.value(stack_positions(demonstrations)).leftCols(judged);
  MotionErrors errors;
  errors.mse = mean_squared_error(predicted, velocity);
  errors.sd = error_deviation(predicted, velocity);
  for (const Demonstration& shown : demonstrations) {
    const Vector times = shown.time.array() - shown.time[0];
    const Points rolled = roll_out_at(f, shown.position.row(0).transpose(), times, options).leftCols(judged);
    const Points position = shown.position.leftCols(judged);
    errors.dtw += dtw(rolled, position);
    errors.dtw_independent += dtw_independent(rolled, position);
  }
  errors.dtw /= static_cast<double>(demonstrations.size());
  errors.dtw_independent /= static_cast<double>(demonstrations.size());
  return errors;
}

}  // namespace s2nnds
