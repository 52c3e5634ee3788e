// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/conformal.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/verification/band_sampler.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check_probabilities(const char* where, double epsilon, double beta) {
  check(epsilon > 0.0 && epsilon < 1.0, "{}: found epsilon = {}, expected in (0, 1)", where, epsilon);
  check(beta > 0.0 && beta < 1.0, "{}: found beta = {}, expected in (0, 1)", where, beta);
}

// The probability that order l claims too much: I_{1-epsilon}(N + 1 - l, l) = P(Binomial(N, epsilon) <= l -
// 1). Written with epsilon, never 1 - epsilon, so that nothing cancels; l = 1 is (1 - epsilon)^N.
double failure_probability(std::int64_t samples, std::int64_t order, double epsilon) {
  const auto n = static_cast<double>(samples);
  const auto l = static_cast<double>(order);
  if (order == 1) return std::exp(n * std::log1p(-epsilon));
  return boost::math::ibetac(l, n + 1.0 - l, epsilon);
}

const RegionPtr* region_of(Condition condition, const SafetyProblem& problem) {
  switch (condition) {
    case Condition::initial:
      return &problem.initial;
    case Condition::unsafe:
      return &problem.unsafe;
    case Condition::containment:
      return &problem.workspace_margin;
    default:
      return nullptr;
  }
}

// False only where the condition's region is provably empty (no obstacle, no margin): nothing is to be
// checked then.
bool has_region(Condition condition, const SafetyProblem& problem) {
  const RegionPtr* region = region_of(condition, problem);
  if (!region) return true;
  return *region && (*region)->classify(problem.workspace) != Location::outside;
}

std::vector<Condition> conditions_to_check(const SafetyProblem& problem) {
  std::vector<Condition> found;
  for (const Condition condition : all_conditions) {
    if (has_region(condition, problem)) found.push_back(condition);
  }
  return found;
}

// Scores of `count` i.i.d. uniform points of a region within X; none if no point of the region can be found.
Vector scores_in(const RegionPtr& region, Condition condition, const Networks& networks,
                 const SafetyProblem& problem, double level_band, std::int64_t count, RandomStream& random) {
  const RegionSampler sampler(region, problem.workspace);
  if (sampler.empty()) return {};
  return residual(condition, networks, problem, level_band,
                  sampler.sample(static_cast<std::size_t>(count), random));
}

// Scores of `count` i.i.d. uniform points of the band |B| <= level_band within X; none if it cannot be
// sampled.
Vector scores_in_band(const Networks& networks, const SafetyProblem& problem, double level_band,
                      std::int64_t count, RandomStream& random) {
  const Points x = BandSampler(networks.B, problem.workspace, level_band).sample(count, random);
  if (x.rows() < count) return {};
  return residual(Condition::barrier_decrease, networks, problem, level_band, x);
}

Vector calibration_scores(Condition condition, const Networks& networks, const SafetyProblem& problem,
                          double level_band, std::int64_t count, RandomStream& random) {
  if (condition == Condition::barrier_decrease)
    return scores_in_band(networks, problem, level_band, count, random);
  if (const RegionPtr* region = region_of(condition, problem)) {
    return scores_in(*region, condition, networks, problem, level_band, count, random);
  }
  return residual(condition, networks, problem, level_band, uniform_points(problem.workspace, count, random));
}

// Counts `scores` into the verdict; a score that is not a number is the worst there is.
void count_scores(Condition condition, const Vector& scores, ConditionVerdict& verdict) {
  for (const double score : scores) {
    if (score == -kInfinity) continue;
    const double ordered = std::isnan(score) ? kInfinity : score;
    verdict.worst = verdict.samples == 0 ? ordered : std::max(verdict.worst, ordered);
    verdict.samples += 1;
    verdict.violations += is_violated(condition, score) ? 1 : 0;
  }
}

double quantile(Vector scores, std::int64_t order) {
  for (double& score : scores) {
    if (std::isnan(score)) score = kInfinity;
  }
  const auto nth = scores.begin() + (scores.size() - order);
  std::nth_element(scores.begin(), nth, scores.end());
  return *nth;
}

ConditionVerdict calibrate(Condition condition, const Vector& scores, std::int64_t order, double beta) {
  ConditionVerdict verdict;
  verdict.condition = condition;
  verdict.method = Method::conformal;
  verdict.verdict = Verdict::failed;
  count_scores(condition, scores, verdict);
  if (scores.size() == 0) return verdict;
  verdict.quantile = quantile(scores, order);
  verdict.tightest_epsilon = tightest_epsilon(scores.size(), verdict.violations, beta);
  if (!is_violated(condition, verdict.quantile)) verdict.verdict = Verdict::passed;
  return verdict;
}

}  // namespace

std::optional<std::int64_t> conformal_order(std::int64_t samples, double epsilon, double beta) {
  check(samples >= 1, "conformal_order: found samples = {}, expected >= 1", samples);
  check_probabilities("conformal_order", epsilon, beta);
  if (!(failure_probability(samples, 1, epsilon) <= beta)) return std::nullopt;
  // The failure probability grows with l: it is within beta at `good` and not at `bad`.
  std::int64_t good = 1;
  std::int64_t bad = samples + 1;
  while (bad - good > 1) {
    const std::int64_t middle = good + (bad - good) / 2;
    (failure_probability(samples, middle, epsilon) <= beta ? good : bad) = middle;
  }
  return good;
}

std::int64_t least_samples(double epsilon, double beta) {
  check_probabilities("least_samples", epsilon, beta);
  const double bound = std::log(beta) / std::log1p(-epsilon);
  check(bound < 0x1p53,
        "least_samples: found epsilon = {}, beta = {}: no countable number of samples is enough", epsilon,
        beta);
  // The quotient may be rounded across an integer: settle it by the test that conformal_order makes.
  auto samples = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(bound)) - 1);
  while (!(failure_probability(samples, 1, epsilon) <= beta)) ++samples;
  return samples;
}

double tightest_epsilon(std::int64_t samples, std::int64_t violations, double beta) {
  check(samples >= 1, "tightest_epsilon: found samples = {}, expected >= 1", samples);
  check(violations >= 0 && violations <= samples, "tightest_epsilon: found violations = {}, expected 0 to {}",
        violations, samples);
  check(beta > 0.0 && beta < 1.0, "tightest_epsilon: found beta = {}, expected in (0, 1)", beta);
  if (violations == samples) return 1.0;
  const auto n = static_cast<double>(samples);
  const auto k = static_cast<double>(violations);
  if (violations == 0) return -std::expm1(std::log(beta) / n);
  return boost::math::ibetac_inv(k + 1.0, n - k, beta);
}

double beta_of_attempt(double beta, std::int64_t attempt) {
  check(attempt >= 1, "beta_of_attempt: found attempt = {}, expected >= 1", attempt);
  const auto j = static_cast<double>(attempt);
  return beta / (j * (j + 1.0));
}

void ConformalOptions::visit(FieldVisitor& v) {
  v.field("samples", samples, at_least(1));
  v.field("epsilon", epsilon, inside(0, 1));
  v.field("beta", beta, inside(0, 1));
}

void SampledOptions::visit(FieldVisitor& v) { v.field("samples", samples, at_least(10)); }

std::vector<ConditionVerdict> verify_conformal(const Networks& networks, const SafetyProblem& problem,
                                               double level_band, const ConformalOptions& options,
                                               std::uint64_t seed, std::int64_t attempt) {
  check_probabilities("verify_conformal", options.epsilon, options.beta);
  const std::vector<Condition> conditions = conditions_to_check(problem);
  const double beta = beta_of_attempt(options.beta, attempt) / static_cast<double>(conditions.size());
  const auto order = conformal_order(options.samples, options.epsilon, beta);
  check(order.has_value(),
        "verify_conformal: found samples = {}, expected >= {} (= ln beta / ln(1 - epsilon)) for epsilon = {} "
        "and "
        "beta = {:.4g} a condition at attempt {}",
        options.samples, least_samples(options.epsilon, beta), options.epsilon, beta, attempt);
  std::vector<ConditionVerdict> verdicts;
  for (const Condition condition : conditions) {
    const Stopwatch watch;
    RandomStream random(seed, fmt::format("conformal/{}", to_string(condition)),
                        static_cast<std::uint64_t>(attempt));
    const Vector scores =
        calibration_scores(condition, networks, problem, level_band, options.samples, random);
    ConditionVerdict verdict = calibrate(condition, scores, *order, beta);
    verdict.seed = static_cast<std::int64_t>(seed);
    verdict.attempt = attempt;
    verdict.epsilon = options.epsilon;
    verdict.beta = beta;
    verdict.order = *order;
    verdict.seconds = watch.seconds();
    verdicts.push_back(std::move(verdict));
  }
  return verdicts;
}

std::vector<ConditionVerdict> verify_sampled(const Networks& networks, const SafetyProblem& problem,
                                             double level_band, const SampledOptions& options,
                                             std::uint64_t seed) {
  check(options.samples >= 10, "verify_sampled: found samples = {}, expected >= 10", options.samples);
  const Stopwatch shared;
  RandomStream random(seed, "sampled/workspace");
  const Points everywhere =
      residuals(networks, problem, level_band, uniform_points(problem.workspace, options.samples, random));
  const double shared_seconds = shared.seconds();
  std::vector<ConditionVerdict> verdicts;
  for (const Condition condition : conditions_to_check(problem)) {
    const Stopwatch watch;
    ConditionVerdict verdict;
    verdict.condition = condition;
    verdict.method = Method::sampled;
    verdict.seed = static_cast<std::int64_t>(seed);
    count_scores(condition, everywhere.col(static_cast<Eigen::Index>(condition)), verdict);
    const RegionPtr* region = region_of(condition, problem);
    if (region) {
      RandomStream own(seed, fmt::format("sampled/{}", to_string(condition)));
      count_scores(condition,
                   scores_in(*region, condition, networks, problem, level_band, options.samples / 10, own),
                   verdict);
    }
    // A band that no sample hits is a band without a counterexample; a set that was never hit was never
    // checked.
    const bool checked = verdict.samples > 0 || !region;
    verdict.verdict = checked && verdict.violations == 0 ? Verdict::passed : Verdict::failed;
    verdict.seconds = watch.seconds() + (verdicts.empty() ? shared_seconds : 0.0);
    verdicts.push_back(std::move(verdict));
  }
  return verdicts;
}

}  // namespace s2nnds
