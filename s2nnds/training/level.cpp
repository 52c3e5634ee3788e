// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/level.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "s2nnds/conditions/worst_perturbation.h"
#include "s2nnds/networks/dynamics.h"

namespace s2nnds {
namespace {

// From `high` down, the first c that is no nearer than `distance` to any of the values.
double highest_free(double high, double distance, std::vector<double> values) {
  std::sort(values.begin(), values.end(), std::greater<>());
  double c = high;
  for (const double value : values) {
    if (value > c + distance) continue;
    if (value < c - distance) break;
    c = value - distance;
  }
  return c;
}

}  // namespace

LevelChoice::LevelChoice(const SafetyProblem& problem, const LevelOptions& options)
    : workspace_(problem.workspace), options_(options), initial_(sampler_of(problem.initial, workspace_)) {
  for (const RegionPtr& region : {problem.unsafe, problem.workspace_margin}) {
    if (auto sampler = sampler_of(region, workspace_)) outside_.push_back(std::move(*sampler));
  }
}

std::optional<double> LevelChoice::largest(const Networks& networks, RandomStream& random) const {
  const std::int64_t in_region = std::max<std::int64_t>(1, options_.samples * 2 / 5);
  const BasicEvaluator<float> f(networks.f), B(networks.B);  // enough for a proposal
  double low = -options_.reach, high = options_.reach;
  if (initial_) low = std::max(low, B.value(initial_->sample(in_region, random)).maxCoeff() + options_.slack);
  for (const RegionSampler& sampler : outside_)
    high = std::min(high, B.value(sampler.sample(in_region, random)).minCoeff() - options_.slack);
  if (!(low <= high)) return std::nullopt;

  const Points all = uniform_points(workspace_, options_.samples, random);
  const Points values = B.value(all);
  if (!values.allFinite()) return std::nullopt;  // an overflowing network has no level sets
  // Others are near to no level that could be chosen.
  std::vector<Eigen::Index> near;
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    if (std::abs(values(i, 0)) <= options_.reach + 2.0 * options_.level_band) near.push_back(i);
  }
  if (near.empty()) return high;
  const Points x = all(near, Eigen::all), velocity = BasicDynamicsEvaluator<float>(networks).value(x);
  Points value, derivative;
  B.value_and_derivative(x, velocity, value, derivative);
  if (options_.execution.asks_of_barrier())
    derivative.col(0) += perturbation_work<float>(options_.execution.model, B, f, x, velocity);
  std::vector<double> forbidden;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    if (!(derivative(i, 0) <= -options_.slack_decrease)) forbidden.push_back(value(i, 0));
  }
  const double c = highest_free(high, 1.5 * options_.level_band, std::move(forbidden));
  if (!(low <= c)) return std::nullopt;
  return c;
}

}  // namespace s2nnds
