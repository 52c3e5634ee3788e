// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/level.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "s2nnds/conditions/worst_perturbation.h"
#include "s2nnds/networks/dynamics.h"
#include "s2nnds/training/training_sampler.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kBands = 1.5;  // around c, in which Bdot is looked at
constexpr int kLevelsTried = 40;

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
    : workspace_(problem.workspace),
      options_(options),
      initial_(training_sampler(problem.initial, workspace_, "level")) {
  for (const RegionPtr& region : {problem.unsafe, problem.workspace_margin}) {
    if (auto sampler = training_sampler(region, workspace_, "level")) outside_.push_back(std::move(*sampler));
  }
}

std::optional<LevelChoice::Look> LevelChoice::look(const Networks& networks, RandomStream& random) const {
  const std::int64_t in_region = std::max<std::int64_t>(1, options_.samples * 2 / 5);
  const BasicEvaluator<float> f(networks.f), B(networks.B);  // enough for a proposal
  Look found{.most_initial = -kInfinity,
             .least_outside = kInfinity,
             .low = 0,
             .high = 0,
             .value = {},
             .derivative = {}};
  if (initial_) found.most_initial = B.value(initial_->sample(in_region, random)).maxCoeff();
  for (const RegionSampler& sampler : outside_)
    found.least_outside =
        std::min(found.least_outside, B.value(sampler.sample(in_region, random)).minCoeff());
  found.low = std::max(-options_.reach, found.most_initial + options_.slack);
  found.high = std::min(options_.reach, found.least_outside - options_.slack);
  if (!(found.low <= found.high)) return std::nullopt;

  const Points all = uniform_points(workspace_, options_.samples, random);
  const Points values = B.value(all);
  if (!values.allFinite()) return std::nullopt;  // an overflowing network has no level sets
  // Others are near to no level that could be chosen.
  std::vector<Eigen::Index> near;
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    if (std::abs(values(i, 0)) <= options_.reach + 2.0 * options_.level_band) near.push_back(i);
  }
  if (near.empty()) return found;
  const Points x = all(near, Eigen::all), velocity = BasicDynamicsEvaluator<float>(networks).value(x);
  Points value, derivative;
  B.value_and_derivative(x, velocity, value, derivative);
  if (options_.execution.asks_of_barrier())
    derivative.col(0) += perturbation_work<float>(options_.execution.model, B, f, x, velocity);
  found.value = value.col(0);
  found.derivative = derivative.col(0);
  return found;
}

std::optional<double> LevelChoice::largest(const Networks& networks, RandomStream& random) const {
  const std::optional<Look> seen = look(networks, random);
  if (!seen) return std::nullopt;
  std::vector<double> forbidden;
  for (Eigen::Index i = 0; i < seen->value.size(); ++i) {
    if (!(seen->derivative[i] <= -options_.slack_decrease)) forbidden.push_back(seen->value[i]);
  }
  const double c = highest_free(seen->high, kBands * options_.level_band, std::move(forbidden));
  if (!(seen->low <= c)) return std::nullopt;
  return c;
}

std::optional<double> LevelChoice::safest(const Networks& networks, RandomStream& random) const {
  const std::optional<Look> seen = look(networks, random);
  if (!seen) return std::nullopt;
  const auto share = [&](double margin, double wanted) { return margin / std::max(wanted, options_.slack); };
  const auto least_share = [&](double c) {
    double worst = -kInfinity;  // Bdot
    for (Eigen::Index i = 0; i < seen->value.size(); ++i) {
      if (std::abs(seen->value[i] - c) > kBands * options_.level_band) continue;
      worst = std::isnan(seen->derivative[i]) ? kInfinity : std::max(worst, seen->derivative[i]);
    }
    return std::min({share(c - seen->most_initial, options_.margin_initial),
                     share(seen->least_outside - c, options_.margin_unsafe),
                     share(-worst, options_.margin_decrease), 1.0});
  };
  double best = seen->high, best_share = least_share(best);
  for (int k = 1; k <= kLevelsTried; ++k) {
    const double c = seen->high - (seen->high - seen->low) * k / kLevelsTried;
    if (const double found = least_share(c); found > best_share) best = c, best_share = found;
  }
  return best;
}

}  // namespace s2nnds
