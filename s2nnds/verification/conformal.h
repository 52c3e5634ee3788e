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
// with confidence 1 - beta iff I_{1-epsilon}(N + 1 - l, l) <= beta.

// The largest such l >= 1; nullopt when (1 - epsilon)^N > beta, that is N < ln(beta) / ln(1 - epsilon).
std::optional<std::int64_t> conformal_order(std::int64_t samples, double epsilon, double beta);

// The least N for which an order exists.
std::int64_t least_samples(double epsilon, double beta);

// The least epsilon for which p <= 0 when k of N scores are positive: the Clopper-Pearson upper bound, the
// root of I_{1-epsilon}(N - k, k + 1) = beta. 1 if k = N.
double tightest_epsilon(std::int64_t samples, std::int64_t violations, double beta);

// The share of beta that attempt j >= 1 may spend: beta / (j (j + 1)); all attempts together spend beta.
double beta_of_attempt(double beta, std::int64_t attempt);

struct ConformalOptions {
  std::int64_t samples = 250000;  // a region: X, X0, Xu, the workspace margin, the band
  double epsilon = 1e-4;
  double beta = 1e-4;  // split evenly over the conditions that need samples

  void visit(FieldVisitor& v);
};

// Calibrates each condition on its own region with fresh samples from the streams ("conformal", attempt).
// Throws Error when `samples` are too few for epsilon and beta.
std::vector<ConditionVerdict> verify_conformal(const Networks& networks, const SafetyProblem& problem,
                                               double level_band, const ConformalOptions& options,
                                               std::uint64_t seed, std::int64_t attempt);

struct SampledOptions {
  std::int64_t samples = 200000;  // i.i.d. in X, and a tenth each in X0, Xu and the workspace margin

  void visit(FieldVisitor& v);
};
std::vector<ConditionVerdict> verify_sampled(const Networks& networks, const SafetyProblem& problem,
                                             double level_band, const SampledOptions& options,
                                             std::uint64_t seed);

}  // namespace s2nnds
