// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/climb.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace s2nnds {
namespace {

constexpr std::size_t kClimbers = 500;
constexpr int kSteps = 20;
// The first step's standard deviation, as a share of the workspace's largest half width, and how much shorter each
// next one is.
constexpr double kFirstStep = 0.1, kShorter = 0.8;

}  // namespace

std::vector<Eigen::Index> worst_rows(const Vector& rank, std::size_t most) {
  const auto key = [&](Eigen::Index i) {
    return std::isnan(rank[i]) ? std::numeric_limits<double>::infinity() : rank[i];
  };
  std::vector<Eigen::Index> order(static_cast<std::size_t>(rank.size()));
  std::iota(order.begin(), order.end(), 0);
  const std::size_t count = std::min(most, order.size());
  std::partial_sort(
      order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
      [&](Eigen::Index a, Eigen::Index b) { return key(a) != key(b) ? key(a) > key(b) : a < b; });
  order.resize(count);
  return order;
}

Counterexamples climb(Condition condition, const Networks& networks, const SafetyProblem& problem,
                      double level_band, const Points& x, const Vector& rank, double near,
                      RandomStream& random, const std::function<void(Points&)>& onto) {
  Points best = x(worst_rows(rank, kClimbers), Eigen::all);
  Vector value = residual(condition, networks, problem, level_band, best);
  double length = kFirstStep * problem.workspace.half_widths().maxCoeff();
  for (int step = 0; step < kSteps && best.rows() > 0; ++step, length *= kShorter) {
    Points trial = best;
    for (Eigen::Index i = 0; i < trial.rows(); ++i) {
      for (Eigen::Index k = 0; k < trial.cols(); ++k) {
        trial(i, k) = std::clamp(trial(i, k) + length * random.normal(), problem.workspace.lower[k],
                                 problem.workspace.upper[k]);
      }
    }
    if (onto) onto(trial);
    const Vector reached = residual(condition, networks, problem, level_band, trial);  // -infinity elsewhere
    for (Eigen::Index i = 0; i < trial.rows(); ++i) {
      if (!(reached[i] > value[i])) continue;
      best.row(i) = trial.row(i);
      value[i] = reached[i];
    }
  }
  std::vector<Eigen::Index> handed_on = worst_rows(value, counterexamples_kept);
  std::erase_if(handed_on,
                [&](Eigen::Index i) { return value[i] <= -near && !is_violated(condition, value[i]); });
  Counterexamples found;
  const auto q = static_cast<std::size_t>(condition);
  found.samples[q] = x.rows();
  found.counts[q] =
      std::count_if(value.begin(), value.end(), [&](double r) { return is_violated(condition, r); });
  found.points[q] = best(handed_on, Eigen::all);
  return found;
}

}  // namespace s2nnds
