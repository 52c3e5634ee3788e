// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/conformal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// P(Binomial(n, p) <= k), summed in long double: independent of the incomplete beta function.
long double binomial_cdf(std::int64_t n, std::int64_t k, long double p) {
  long double term = std::exp(static_cast<long double>(n) * std::log1p(-p));
  long double sum = term;
  for (std::int64_t i = 1; i <= k; ++i) {
    term *= static_cast<long double>(n - i + 1) / static_cast<long double>(i) * p / (1 - p);
    sum += term;
  }
  return sum;
}

TEST(ConformalOrder, KnownAnswers) {
  EXPECT_EQ(conformal_order(459, 0.01, 0.01), 1);
  EXPECT_EQ(conformal_order(458, 0.01, 0.01), std::nullopt);
  EXPECT_EQ(conformal_order(1000, 0.05, 0.01), 35);
  EXPECT_EQ(conformal_order(10000, 0.01, 0.01), 78);
  EXPECT_EQ(conformal_order(250000, 1e-4, 1e-4), 9);
  EXPECT_EQ(conformal_order(640000, 1e-4, 1e-4), 37);
}

TEST(ConformalOrder, IsTheLargestAdmissibleOne) {
  for (const std::int64_t samples : {100, 459, 1500, 7777, 20000}) {
    for (const double epsilon : {0.003, 0.02, 0.1}) {
      for (const double beta : {1e-6, 0.01, 0.3}) {
        const auto order = conformal_order(samples, epsilon, beta);
        if (!order) {
          EXPECT_GT(binomial_cdf(samples, 0, epsilon), beta);
          continue;
        }
        EXPECT_LE(binomial_cdf(samples, *order - 1, epsilon), beta)
            << samples << " " << epsilon << " " << beta;
        EXPECT_GT(binomial_cdf(samples, *order, epsilon), beta) << samples << " " << epsilon << " " << beta;
      }
    }
  }
}

TEST(ConformalOrder, HoldsAtExtremeConfidence) {
  // (1 - epsilon)^N = e^-100: the order must not be lost to cancellation.
  const double epsilon = 1e-6;
  EXPECT_EQ(conformal_order(100'000'000, epsilon, std::exp(-100.0) * 1.001), 1);
  EXPECT_EQ(conformal_order(100'000'000, epsilon, std::exp(-100.0) * 0.99), std::nullopt);
}

TEST(ConformalOrder, RefusesMisuse) {
  EXPECT_THROW(conformal_order(0, 0.1, 0.1), Error);
  EXPECT_THROW(conformal_order(10, 0.0, 0.1), Error);
  EXPECT_THROW(conformal_order(10, 0.1, 1.0), Error);
  EXPECT_THROW(conformal_order(10, std::nan(""), 0.1), Error);
}

TEST(LeastSamples, IsWhereAnOrderBegins) {
  EXPECT_EQ(least_samples(0.01, 0.01), 459);
  for (const double epsilon : {0.5, 0.03, 1e-4}) {
    for (const double beta : {0.25, 1e-3, 1e-9}) {
      const std::int64_t least = least_samples(epsilon, beta);
      EXPECT_TRUE(conformal_order(least, epsilon, beta).has_value());
      if (least > 1) {
        EXPECT_FALSE(conformal_order(least - 1, epsilon, beta).has_value());
      }
    }
  }
}

TEST(TightestEpsilon, KnownAnswers) {
  EXPECT_NEAR(tightest_epsilon(100000, 3, 1e-4), 1.591278649738e-4, 1e-15);
  EXPECT_NEAR(static_cast<double>(binomial_cdf(100000, 3, 1.591278649738e-4L)), 1e-4, 1e-14);
  EXPECT_EQ(tightest_epsilon(50, 50, 1e-4), 1.0);
  EXPECT_NEAR(tightest_epsilon(459, 0, 0.01), 1.0 - std::pow(0.01, 1.0 / 459.0), 1e-15);
}

TEST(TightestEpsilon, IsWhereTheOrderReachesTheViolations) {
  for (const std::int64_t violations : {0, 1, 7, 40}) {
    const double epsilon = tightest_epsilon(20000, violations, 1e-5);
    EXPECT_EQ(conformal_order(20000, epsilon * (1 + 1e-9), 1e-5).value_or(0), violations + 1);
    EXPECT_EQ(conformal_order(20000, epsilon * (1 - 1e-9), 1e-5).value_or(0), violations);
  }
}

TEST(BetaOfAttempt, AllAttemptsSpendBetaOnce) {
  double spent = 0.0;
  for (std::int64_t attempt = 1; attempt <= 100000; ++attempt) spent += beta_of_attempt(0.01, attempt);
  EXPECT_LE(spent, 0.01);
  EXPECT_GT(spent, 0.00999);
  EXPECT_EQ(beta_of_attempt(0.01, 1), 0.005);
  EXPECT_THROW(beta_of_attempt(0.01, 0), Error);
}

NetworkWeights linear(const Points& weight, const Vector& bias = {}) {
  return {.layers = {{.weight = weight, .bias = bias, .activation = Activation::identity}}};
}

// f = -x, V = 1.5 |x|^2, B = x1 - 0.5 on [-1, 1]^2: every condition holds.
Networks good_networks() {
  Networks networks;
  networks.f = linear(-Points::Identity(2, 2));
  networks.V = linear(Points::Identity(2, 2));
  networks.V.head = Head::squared_norm;
  networks.V.quadratic = 0.5;
  networks.B = linear(Points{{1.0, 0.0}}, Vector::Constant(1, -0.5));
  return networks;
}

SafetyProblem good_problem() {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = ball(Vector{{-0.5, 0.5}}, 0.1);
  problem.unsafe = box_region({Vector{{0.6, -0.2}}, Vector{{0.8, 0.2}}});
  return problem;
}

std::map<std::string, ConditionVerdict> by_condition(const std::vector<ConditionVerdict>& verdicts) {
  std::map<std::string, ConditionVerdict> named;
  for (const ConditionVerdict& verdict : verdicts) named[std::string(to_string(verdict.condition))] = verdict;
  return named;
}

constexpr double kBand = 0.1;
const ConformalOptions kQuick{.samples = 2000, .epsilon = 0.01, .beta = 0.01};
const SampledOptions kFewSamples{.samples = 20000};

TEST(VerifyConformal, PassesAGoodSystem) {
  const auto verdicts = verify_conformal(good_networks(), good_problem(), kBand, kQuick, 1, 1);
  EXPECT_EQ(verdicts.size(), 5U);  // no margin, no containment
  for (const ConditionVerdict& verdict : verdicts) {
    EXPECT_EQ(verdict.verdict, Verdict::passed) << to_string(verdict.condition);
    EXPECT_EQ(verdict.method, Method::conformal);
    EXPECT_EQ(verdict.samples, 2000);
    EXPECT_EQ(verdict.violations, 0);
    EXPECT_DOUBLE_EQ(verdict.beta, 0.01 / 2 / 5);
    EXPECT_EQ(verdict.order, conformal_order(2000, 0.01, verdict.beta));
    EXPECT_EQ(verdict.tightest_epsilon, tightest_epsilon(2000, 0, verdict.beta));
    EXPECT_LT(verdict.tightest_epsilon, verdict.epsilon);
    EXPECT_LE(verdict.quantile, verdict.worst);
    EXPECT_LT(verdict.worst, 0.0);
  }
}

TEST(VerifyConformal, SamplesTheBandItself) {
  const auto verdicts = by_condition(verify_conformal(good_networks(), good_problem(), kBand, kQuick, 1, 1));
  // Bdot = -x1 is in [-0.6, -0.4] there, and uniform.
  const ConditionVerdict& band = verdicts.at("barrier_decrease");
  EXPECT_LE(band.worst, -0.4);
  EXPECT_GT(band.worst, -0.402);
}

TEST(VerifyConformal, SmallViolationsFailOnlyTheirCondition) {
  SafetyProblem problem = good_problem();
  problem.unsafe = box_region({Vector{{0.48, -0.2}}, Vector{{0.88, 0.2}}});  // a twentieth of it has B <= 0
  const auto verdicts = by_condition(verify_conformal(good_networks(), problem, kBand, kQuick, 1, 1));
  for (const auto& [name, verdict] : verdicts)
    EXPECT_EQ(verdict.verdict, name == "unsafe" ? Verdict::failed : Verdict::passed);
  const ConditionVerdict& unsafe = verdicts.at("unsafe");
  // Within six standard deviations of N / 20: a false alarm in 5e8.
  EXPECT_NEAR(static_cast<double>(unsafe.violations), 100.0, 6 * std::sqrt(2000 * 0.05 * 0.95));
  EXPECT_GT(unsafe.quantile, 0.0);
  EXPECT_NEAR(unsafe.worst, 0.02, 1e-3);
  EXPECT_GT(unsafe.tightest_epsilon, 0.05 - 0.02);
  EXPECT_LT(unsafe.tightest_epsilon, 0.09);
}

TEST(VerifyConformal, ABoundaryThatStrictConditionsForbidFails) {
  Networks networks = good_networks();
  networks.f = linear(Points::Zero(2, 2));  // everything rests: Vdot = 0, Bdot = 0
  const auto verdicts = by_condition(verify_conformal(networks, good_problem(), kBand, kQuick, 1, 1));
  EXPECT_EQ(verdicts.at("lyapunov_decrease").verdict, Verdict::failed);
  EXPECT_EQ(verdicts.at("lyapunov_decrease").quantile, 0.0);
  EXPECT_EQ(verdicts.at("barrier_decrease").verdict, Verdict::failed);
  networks = good_networks();
  networks.B = linear(Points{{0.0, 0.0}});  // B = 0: allowed on X0, forbidden on Xu
  const auto flat = by_condition(verify_conformal(networks, good_problem(), kBand, kQuick, 1, 1));
  EXPECT_EQ(flat.at("initial").verdict, Verdict::passed);
  EXPECT_EQ(flat.at("unsafe").verdict, Verdict::failed);
}

TEST(VerifyConformal, NotANumberFails) {
  Networks networks = good_networks();
  networks.V = {.layers = {{.weight = Points{{1e200, 0.0}, {1e200, 0.0}}, .bias = {}},
                           {.weight = Points{{1e200, -1e200}}, .bias = {}}}};
  for (const auto& verdicts : {verify_conformal(networks, good_problem(), kBand, kQuick, 1, 1),
                               verify_sampled(networks, good_problem(), kBand, kFewSamples, 1)}) {
    const auto named = by_condition(verdicts);
    EXPECT_EQ(named.at("lyapunov_positive").verdict, Verdict::failed);
    EXPECT_EQ(named.at("lyapunov_decrease").verdict, Verdict::failed);
    EXPECT_EQ(named.at("lyapunov_decrease").violations, named.at("lyapunov_decrease").samples);
    EXPECT_EQ(named.at("lyapunov_decrease").worst, std::numeric_limits<double>::infinity());
    EXPECT_EQ(named.at("initial").verdict, Verdict::passed);
  }
}

TEST(VerifyConformal, ABandThatCannotBeSampledFails) {
  Networks networks = good_networks();
  networks.B = linear(Points{{0.0, 0.0}}, Vector::Constant(1, -1.0));
  const auto verdicts = by_condition(verify_conformal(networks, good_problem(), kBand, kQuick, 1, 1));
  EXPECT_EQ(verdicts.at("barrier_decrease").verdict, Verdict::failed);
  EXPECT_EQ(verdicts.at("barrier_decrease").samples, 0);
  EXPECT_EQ(verdicts.at("barrier_decrease").tightest_epsilon, 1.0);
}

TEST(VerifyConformal, RegionsThatDoNotExistGetNoVerdict) {
  SafetyProblem problem = good_problem();
  problem.unsafe = empty_region(2);
  problem.workspace_margin = complement(box_region(Box::cube(2, 0.97)));
  const auto verdicts = by_condition(verify_conformal(good_networks(), problem, kBand, kQuick, 1, 1));
  EXPECT_EQ(verdicts.count("unsafe"), 0U);
  EXPECT_EQ(verdicts.at("containment").verdict, Verdict::failed);  // B < 0 on most of the workspace margin
}

TEST(VerifyConformal, EachAttemptDrawsAnewAndSpendsLess) {
  const auto first = verify_conformal(good_networks(), good_problem(), kBand, kQuick, 1, 1);
  const auto again = verify_conformal(good_networks(), good_problem(), kBand, kQuick, 1, 1);
  const auto second = verify_conformal(good_networks(), good_problem(), kBand, kQuick, 1, 2);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].quantile, again[i].quantile);
    EXPECT_EQ(first[i].worst, again[i].worst);
    EXPECT_NE(first[i].worst, second[i].worst);
    EXPECT_DOUBLE_EQ(second[i].beta, first[i].beta / 3);
    EXPECT_EQ(second[i].attempt, 2);
  }
}

TEST(VerifyConformal, TooFewSamplesAreRefusedWithTheNumberNeeded) {
  ConformalOptions options = kQuick;
  options.samples = least_samples(options.epsilon, 0.01 / 2 / 5) - 1;
  try {
    verify_conformal(good_networks(), good_problem(), kBand, options, 1, 1);
    FAIL() << "expected an Error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(std::to_string(options.samples + 1)), std::string::npos)
        << error.what();
  }
  ++options.samples;
  EXPECT_EQ(verify_conformal(good_networks(), good_problem(), kBand, options, 1, 1).front().order, 1);
}

// The theorem itself: B - const is uniform on X0, so the coverage P(B <= p) of the reported p is known
// exactly. It may fall short of 1 - epsilon in a share of at most beta of all calibrations; the exact share
// is I_{1-eps}(N+1-l, l).
TEST(VerifyConformal, CoverageFallsShortAsOftenAsTheTheoremSays) {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = box_region({Vector{{-0.9, -0.5}}, Vector{{0.1, 0.5}}});  // x1 uniform on [-0.9, 0.1]
  problem.unsafe = empty_region(2);
  const ConformalOptions options{.samples = 32, .epsilon = 0.2, .beta = 0.8};
  const double beta = 0.8 / 2 / 4;  // first attempt, four conditions
  constexpr int repetitions = 2000;
  int short_of_it = 0;
  std::int64_t order = 0;
  for (int seed = 0; seed < repetitions; ++seed) {
    const auto verdicts = by_condition(
        verify_conformal(good_networks(), problem, kBand, options, static_cast<std::uint64_t>(seed), 1));
    const ConditionVerdict& initial = verdicts.at("initial");
    ASSERT_DOUBLE_EQ(initial.beta, beta);
    order = initial.order;
    const double coverage = initial.quantile + 0.5 + 0.9;  // B = x1 - 0.5
    short_of_it += coverage < 1 - options.epsilon ? 1 : 0;
  }
  const auto exact = static_cast<double>(binomial_cdf(options.samples, order - 1, options.epsilon));
  EXPECT_LE(exact, beta);
  // Five standard deviations either way: a false alarm in about 1e6.
  const double margin = 5 * std::sqrt(repetitions * exact * (1 - exact));
  EXPECT_NEAR(short_of_it, repetitions * exact, margin);
}

TEST(VerifySampled, PassesAGoodSystemAndCountsWhereConditionsApply) {
  const auto verdicts = by_condition(verify_sampled(good_networks(), good_problem(), kBand, kFewSamples, 1));
  EXPECT_EQ(verdicts.size(), 5U);
  for (const auto& [name, verdict] : verdicts) {
    EXPECT_EQ(verdict.verdict, Verdict::passed) << name;
    EXPECT_EQ(verdict.method, Method::sampled);
    EXPECT_EQ(verdict.violations, 0);
    EXPECT_EQ(verdict.seed, 1);
  }
  EXPECT_EQ(verdicts.at("lyapunov_decrease").samples, 20000);
  EXPECT_GE(verdicts.at("initial").samples, 2000);
  EXPECT_GE(verdicts.at("unsafe").samples, 2000);
  EXPECT_NEAR(static_cast<double>(verdicts.at("barrier_decrease").samples), 2000.0, 6 * std::sqrt(1800.0));
}

TEST(VerifySampled, FindsASmallViolation) {
  SafetyProblem problem = good_problem();
  problem.initial = box_region({Vector{{0.401, 0.4}}, Vector{{0.501, 0.5}}});  // a hundredth of it has B > 0
  const auto verdicts = by_condition(verify_sampled(good_networks(), problem, kBand, kFewSamples, 1));
  EXPECT_EQ(verdicts.at("initial").verdict, Verdict::failed);
  EXPECT_GT(verdicts.at("initial").violations, 0);
  EXPECT_EQ(verdicts.at("unsafe").verdict, Verdict::passed);
}

}  // namespace
}  // namespace s2nnds
