// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "s2nnds/conditions/condition.h"
#include "s2nnds/verification/certificate.h"

namespace s2nnds {

// Split conformal verification (the paper's Theorem 1, with floor((N + 1) alpha)): of N i.i.d. scores, p the
// (N + 1 - l)-th smallest has coverage at least Beta(N + 1 - l, l) distributed, so P(s <= p) >= 1 - epsilon
// with confidence 1 - beta iff I_{1-epsilon}(N + 1 - l, l) <= beta, I being the regularised incomplete beta
// function.
// The largest such l >= 1; nullopt when (1 - epsilon)^N > beta, that is N < ln(beta) / ln(1 - epsilon).
// Throws Error unless N >= 1 and epsilon and beta lie in (0, 1).
std::optional<std::int64_t> conformal_order(std::int64_t samples, double epsilon, double beta);

// The least N for which an order exists. Throws Error unless epsilon and beta lie in (0, 1).
std::int64_t least_samples(double epsilon, double beta);

// The least epsilon for which p <= 0 when k of N scores are positive: the Clopper-Pearson upper bound, the
// root of I_{1-epsilon}(N - k, k + 1) = beta. 1 if k = N. Throws Error unless 0 <= k <= N, N >= 1 and beta
// lies in (0, 1).
double tightest_epsilon(std::int64_t samples, std::int64_t violations, double beta);

// The share of beta that attempt j >= 1 may spend: beta / (j (j + 1)); all attempts together spend beta.
double beta_of_attempt(double beta, std::int64_t attempt);

// Settings of verify_conformal: each condition shall hold on all but a share epsilon of its region, with
// confidence 1 - beta for all conditions and attempts together.
struct ConformalOptions {
  // Samples of each region (X, X0, Xu, the workspace margin, the band), >= 1; about ln(1 / beta) / epsilon
  // are the least that can pass.
  std::int64_t samples = 250000;
  double epsilon = 1e-4;  // largest share of a region that may violate its condition, in (0, 1)
  // Largest probability that the statement is wrong, in (0, 1); split over attempts (beta_of_attempt) and
  // evenly over conditions.
  double beta = 1e-4;

  void visit(FieldVisitor& v);  // names each field once
};

// Calibrates each condition on its own region with fresh samples from the streams ("conformal", attempt).
// Throws Error when `samples` are too few for epsilon and beta.
std::vector<ConditionVerdict> verify_conformal(const Networks& networks, const SafetyProblem& problem,
                                               double level_band, const ConformalOptions& options,
                                               std::uint64_t seed, std::int64_t attempt);

// Settings of verify_sampled.
struct SampledOptions {
  // i.i.d. samples in X, and a tenth of that each in X0, Xu and the workspace margin; >= 10.
  std::int64_t samples = 200000;

  void visit(FieldVisitor& v);  // names each field once
};

// Counts violations of each condition at uniform samples. A condition passes when there is none, and when its
// set (X0, Xu, the workspace margin) was hit at all. Throws Error on fewer than 10 samples.
std::vector<ConditionVerdict> verify_sampled(const Networks& networks, const SafetyProblem& problem,
                                             double level_band, const SampledOptions& options,
                                             std::uint64_t seed);

}  // namespace s2nnds
