#include "s2nnds/evaluation/trajectory_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "s2nnds/core/check.h"

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

struct WarpingPath {
  double cost = 0.0;
  Eigen::Index length = 0;

  bool operator<(const WarpingPath& other) const {
    return cost < other.cost || (cost == other.cost && length < other.length);
  }
};

// The cheapest warping path between curves of `rows` and `cols` samples, the shortest of these. Row by row.
template <typename Distance>
WarpingPath cheapest_path(Eigen::Index rows, Eigen::Index cols, const Distance& distance) {
  const WarpingPath unreachable{std::numeric_limits<double>::infinity(), 0};
  std::vector<WarpingPath> above(static_cast<std::size_t>(cols) + 1, unreachable);
  std::vector<WarpingPath> row = above;
  above[0] = {};
  for (Eigen::Index i = 0; i < rows; ++i) {
    row[0] = unreachable;
    for (Eigen::Index j = 0; j < cols; ++j) {
      const auto at = static_cast<std::size_t>(j) + 1;
      const WarpingPath best = std::min(above[at - 1], std::min(above[at], row[at - 1]));
      row[at] = {best.cost + distance(i, j), best.length + 1};
    }
    std::swap(above, row);
  }
  return above.back();
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
  const auto distance = [&](Eigen::Index i, Eigen::Index j) { return (a.row(i) - b.row(j)).norm(); };
  const WarpingPath path = cheapest_path(a.rows(), b.rows(), distance);
  return path.cost / static_cast<double>(path.length);
}

double dtw_independent(const Points& a, const Points& b) {
  check_curves(a, b);
  if (!a.allFinite() || !b.allFinite()) return kNotANumber;
  double sum = 0.0;
  for (Eigen::Index k = 0; k < a.cols(); ++k) {
    const Vector p = a.col(k);
    const Vector q = b.col(k);
    const auto distance = [&](Eigen::Index i, Eigen::Index j) { return (p[i] - q[j]) * (p[i] - q[j]); };
    sum += cheapest_path(p.size(), q.size(), distance).cost;
  }
  return std::sqrt(sum);
}

MotionErrors motion_errors(const NetworkWeights& f, const std::vector<Demonstration>& demonstrations,
                           const RolloutOptions& options) {
  if (demonstrations.empty()) return {kNotANumber, kNotANumber, kNotANumber, kNotANumber};
  const Points velocity = stack_velocities(demonstrations);
  const Points predicted = f.value(stack_positions(demonstrations));
  MotionErrors errors;
  errors.mse = mean_squared_error(predicted, velocity);
  errors.sd = error_deviation(predicted, velocity);
  for (const Demonstration& shown : demonstrations) {
    const Vector times = shown.time.array() - shown.time[0];
    const Points rolled = roll_out_at(f, shown.position.row(0).transpose(), times, options);
    errors.dtw += dtw(rolled, shown.position);
    errors.dtw_independent += dtw_independent(rolled, shown.position);
  }
  errors.dtw /= static_cast<double>(demonstrations.size());
  errors.dtw_independent /= static_cast<double>(demonstrations.size());
  return errors;
}

}  // namespace s2nnds
