// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/falsifier.h"

#include <algorithm>
#include <numeric>

#include "s2nnds/networks/evaluator.h"
#include "s2nnds/training/climb.h"
#include "s2nnds/training/training_sampler.h"

namespace s2nnds {
namespace {

std::vector<RegionSampler> sample_regions(const SafetyProblem& problem, const char* name) {
  std::vector<RegionSampler> samplers;
  for (const RegionPtr& region : {problem.initial, problem.unsafe, problem.workspace_margin}) {
    if (auto sampler = training_sampler(region, problem.workspace, name))
      samplers.push_back(std::move(*sampler));
  }
  return samplers;
}

Points append(const Points& a, const Points& b) {
  Points all(a.rows() + b.rows(), b.cols());
  all << a, b;
  return all;
}

Points all_samples(const SafetyProblem& problem, const std::vector<RegionSampler>& samplers,
                   std::int64_t count, RandomStream& random) {
  Points x = uniform_points(problem.workspace, count, random);
  for (const RegionSampler& sampler : samplers)
    x = append(x, sampler.sample(std::max<std::int64_t>(1, count / 10), random));
  return x;
}

// Of the rows `among`, in ascending order, the `keep` with the largest residual of condition q, largest first.
std::vector<Eigen::Index> worst(const Points& residual, Eigen::Index q, std::size_t keep,
                                const std::vector<Eigen::Index>& among) {
  std::vector<Eigen::Index> rows = worst_rows(residual.col(q)(among), keep);
  for (Eigen::Index& row : rows) row = among[static_cast<std::size_t>(row)];
  return rows;
}

Counterexamples violators(const Points& x, const Points& residual, std::int64_t keep) {
  Counterexamples found;
  for (Eigen::Index q = 0; q < condition_count; ++q) {
    std::vector<Eigen::Index> bad;
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      const double r = residual(i, q);
      if (r == -std::numeric_limits<double>::infinity()) continue;
      ++found.samples[q];
      if (is_violated(all_conditions[q], r)) bad.push_back(i);
    }
    found.counts[q] = static_cast<std::int64_t>(bad.size());
    const std::vector<Eigen::Index> kept = worst(residual, q, keep, bad);
    found.points[q].resize(kept.size(), x.cols());
    for (std::size_t i = 0; i < kept.size(); ++i) found.points[q].row(i) = x.row(kept[i]);
  }
  return found;
}

}  // namespace

std::int64_t Counterexamples::total() const {
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

RandomFalsifier::RandomFalsifier(const SafetyProblem& problem, const FalsifierOptions& options)
    : options_(options), samplers_(sample_regions(problem, "falsifier/random")) {}

Counterexamples RandomFalsifier::find(const Networks& networks, const SafetyProblem& problem,
                                      double level_band, std::uint64_t seed, std::int64_t round) {
  RandomStream random(seed, "falsifier/random", round);
  const Points x = all_samples(problem, samplers_, options_.samples, random);
  // In single precision: whoever calls a run verified has looked again in double.
  return violators(x, residuals(networks, problem, level_band, x, Precision::single_, options_.execution),
                   options_.keep);
}

LocalSearchFalsifier::LocalSearchFalsifier(const SafetyProblem& problem, const FalsifierOptions& options,
                                           int starts, int steps)
    : options_(options),
      samplers_(sample_regions(problem, "falsifier/local search")),
      starts_(starts),
      steps_(steps) {}

Counterexamples LocalSearchFalsifier::find(const Networks& networks, const SafetyProblem& problem,
                                           double level_band, std::uint64_t seed, std::int64_t round) {
  RandomStream random(seed, "falsifier/local search", round);
  const Points x = all_samples(problem, samplers_, options_.samples / 10, random);
  const Points residual = residuals(networks, problem, level_band, x, Precision::double_, options_.execution);
  Counterexamples found;
  for (Eigen::Index q = 0; q < condition_count; ++q) {
    std::vector<Eigen::Index> applicable;
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      if (residual(i, q) != -std::numeric_limits<double>::infinity()) applicable.push_back(i);
    }
    const std::vector<Eigen::Index> starts = worst(residual, q, starts_, applicable);
    if (starts.empty()) continue;
    Points best(starts.size(), x.cols());
    Vector value(starts.size());
    for (std::size_t i = 0; i < starts.size(); ++i) {
      best.row(i) = x.row(starts[i]);
      value[i] = residual(starts[i], q);
    }
    double length = 0.02 * problem.workspace.half_widths().maxCoeff();
    for (int step = 0; step < steps_; ++step, length *= 0.75) {
      Points trial = best;
      for (Eigen::Index i = 0; i < trial.rows(); ++i) {
        for (Eigen::Index k = 0; k < trial.cols(); ++k) {
          trial(i, k) = std::clamp(trial(i, k) + length * random.normal(), problem.workspace.lower[k],
                                   problem.workspace.upper[k]);
        }
      }
      const Points climbed =
          residuals(networks, problem, level_band, trial, Precision::double_, options_.execution);
      for (Eigen::Index i = 0; i < trial.rows(); ++i) {
        if (climbed(i, q) > value[i]) {
          best.row(i) = trial.row(i);
          value[i] = climbed(i, q);
        }
      }
    }
    Points only = Points::Constant(best.rows(), condition_count, -std::numeric_limits<double>::infinity());
    only.col(q) = value;
    const Counterexamples of_q = violators(best, only, options_.keep);
    found.points[q] = of_q.points[q];
    found.counts[q] = of_q.counts[q];
    found.samples[q] = of_q.samples[q];
  }
  return found;
}

RegionFalsifier::RegionFalsifier(const SafetyProblem& problem, std::int64_t samples, double near_initial,
                                 double near_unsafe)
    : samples_(samples), near_initial_(near_initial), near_unsafe_(near_unsafe) {
  for (const auto& [condition, region] :
       {std::pair{Condition::initial, problem.initial}, std::pair{Condition::unsafe, problem.unsafe},
        std::pair{Condition::containment, problem.workspace_margin}}) {
    if (auto sampler = training_sampler(region, problem.workspace, "falsifier/regions"))
      regions_.emplace_back(condition, std::move(*sampler));
  }
}

Counterexamples RegionFalsifier::find(const Networks& networks, const SafetyProblem& problem,
                                      double level_band, std::uint64_t seed, std::int64_t round) {
  RandomStream random(seed, "falsifier/regions", round);
  const BasicEvaluator<float> B(networks.B);
  Counterexamples found;
  for (const auto& [condition, sampler] : regions_) {
    const bool within = condition == Condition::initial;
    const Points x = sampler.sample(static_cast<std::size_t>(samples_), random);
    const Vector rank = (within ? 1.0 : -1.0) * B.value(x).col(0);
    const double near = within ? near_initial_ : near_unsafe_;
    const Counterexamples here = climb(condition, networks, problem, level_band, x, rank, near, random);
    const auto q = static_cast<std::size_t>(condition);
    found.points[q] = here.points[q];
    found.counts[q] = here.counts[q];
    found.samples[q] = here.samples[q];
  }
  return found;
}

}  // namespace s2nnds
