// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/disturbance_margin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "s2nnds/core/parallel.h"
#include "s2nnds/verification/network_function.h"
#include "s2nnds/verification/polynomial_function.h"

namespace s2nnds {
namespace {

Polynomial sum_of_squares(double x, double y, double constant) {
  return Polynomial((Vector(3) << x, y, constant).finished(),
                    (Eigen::MatrixXi(3, 2) << 2, 0, 0, 2, 0, 0).finished());
}
Polynomial linear(double x, double y) {
  return Polynomial((Vector(2) << x, y).finished(), (Eigen::MatrixXi(2, 2) << 1, 0, 0, 1).finished());
}

// xdot = -x, V = x^2 + y^2, B = x^2 / a^2 + y^2 - 1.
ProofFunctions contracting(double a) {
  return {std::make_shared<PolynomialFunction>(std::vector{linear(-1.0, 0.0), linear(0.0, -1.0)}),
          std::make_shared<PolynomialFunction>(std::vector{sum_of_squares(1.0, 1.0, 0.0)}),
          std::make_shared<PolynomialFunction>(std::vector{sum_of_squares(1.0 / (a * a), 1.0, -1.0)})};
}

SafetyProblem plain_problem() {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.25);
  problem.initial = ball(Vector::Constant(2, 0.1), 0.1);
  problem.unsafe = empty_region(2);
  return problem;
}

// On the circle Bdot = -2 and |grad B| = 2: the margin is 1. On the ellipse it is the least distance of a
// tangent from the centre, the shorter half-axis.
TEST(DisturbanceMargin, IsKnownForContractionOnAnEllipse) {
  for (double a : {1.0, 0.5, 0.8}) {
    const DisturbanceMargin found = disturbance_margin(contracting(a), plain_problem());
    EXPECT_LE(found.margin, std::min(a, 1.0)) << a;
    EXPECT_GE(found.margin, 0.95 * std::min(a, 1.0)) << a;
  }
}

// xdot = x (a - |x|^2), B = |x|^2 - 1: on the circle Bdot = -2 (1 - a), and |grad B| = 2. At |x|^2 < a, in boxes that the
// circle meets, Bdot > 0.
TEST(DisturbanceMargin, IsKnownWhereTheBarrierRisesNextToItsLevelSet) {
  const auto radial = [](double a, Eigen::Index axis) {
    Eigen::MatrixXi exponents = (Eigen::MatrixXi(3, 2) << 0, 0, 2, 0, 0, 2).finished();
    exponents.col(axis).array() += 1;
    return Polynomial((Vector(3) << a, -1.0, -1.0).finished(), exponents);
  };
  for (double a : {0.99, 0.7}) {
    ProofFunctions functions = contracting(1.0);
    functions.f = std::make_shared<PolynomialFunction>(std::vector{radial(a, 0), radial(a, 1)});
    const DisturbanceMargin found = disturbance_margin(functions, plain_problem());
    EXPECT_LE(found.margin, 1.0 - a);
    EXPECT_GE(found.margin, 0.95 * (1.0 - a));
  }
}

// One disturbance alone, where B = 0 and in a band around it. On the level c Bdot = -2 (1 + c), and |grad B| is at most
// 2 sqrt(1 + c) / a: the ellipse withstands a sqrt(1 + c).
TEST(BarrierDecrease, WithstandsWhatAnEllipseDoes) {
  constexpr double a = 0.5, band = 0.1;
  const ProofFunctions functions = contracting(a);
  const double on_band = a * std::sqrt(1.0 - band);
  EXPECT_TRUE(prove_barrier_decrease(functions, plain_problem(), 0.0, 0.99 * a).is_proved());
  EXPECT_TRUE(prove_barrier_decrease(functions, plain_problem(), band, 0.99 * on_band).is_proved());
  for (const auto& [level, disturbance] : {std::pair{0.0, 1.01 * a}, std::pair{band, 1.02 * on_band}}) {
    const ConditionProof open =
        prove_barrier_decrease(functions, plain_problem(), level, disturbance, ProofOptions::fail_fast());
    ASSERT_FALSE(open.is_proved());
    ASSERT_EQ(open.verdict.verdict, level > 0.0 ? Verdict::refuted : Verdict::undecided);
    for (Eigen::Index row = 0; row < open.witnesses.rows(); ++row) {
      const double x = open.witnesses(row, 0), y = open.witnesses(row, 1);
      const double slope = 2.0 * std::hypot(x / (a * a), y), rate = -2.0 * (x * x / (a * a) + y * y);
      EXPECT_LE(std::abs(x * x / (a * a) + y * y - 1.0), level);
      EXPECT_GE(rate + disturbance * slope, -1e-12);
    }
  }
  EXPECT_ANY_THROW(prove_barrier_decrease(functions, plain_problem(), 0.0, -1.0));
  EXPECT_FALSE(prove_barrier_decrease(functions, plain_problem(), 0.0,
                                      std::numeric_limits<double>::infinity(), ProofOptions::fail_fast())
                   .is_proved());
}

// Vdot + 2 |x| w < 0 iff |x| > w.
TEST(DisturbanceMargin, ConvergesToTheBallWhereTheDisturbanceWins) {
  for (double disturbance : {0.1, 0.3}) {
    const double radius = convergence_radius(contracting(1.0), plain_problem(), disturbance);
    EXPECT_GE(radius, disturbance);
    EXPECT_LE(radius, disturbance + 0.05);
  }
}

TEST(DisturbanceMargin, NothingIsCertifiedWhereTheBarrierFails) {
  ProofFunctions functions = contracting(1.0);
  functions.f = std::make_shared<PolynomialFunction>(std::vector{linear(1.0, 0.0), linear(0.0, -1.0)});
  const DisturbanceMargin found = disturbance_margin(functions, plain_problem());
  EXPECT_EQ(found.margin, 0.0);
  EXPECT_TRUE(std::isinf(found.convergence_radius));
}

// xdot = -x scaled down and up again: the same field, but what underflows in its first layer comes back 1e160 times.
TEST(DisturbanceMargin, NothingIsCertifiedOfWeightsBeyondTheRangeWhenCalledAlone) {
  const Points contraction = -Points::Identity(2, 2);
  const auto functions = [&](double factor) {
    ProofFunctions made = contracting(0.8);
    made.f = std::make_shared<NetworkFunction>(NetworkWeights{
        .layers = {{.weight = contraction / factor, .bias = {}, .activation = Activation::identity},
                   {.weight = factor * Points::Identity(2, 2),
                    .bias = {},
                    .activation = Activation::identity}},
        .head = Head::zero_at_origin});
    return made;
  };
  const SafetyProblem problem = plain_problem();
  ASSERT_EQ(functions(1.0).beyond_range(problem.workspace), "");
  EXPECT_GT(disturbance_margin(functions(1.0), problem).margin, 0.7);
  EXPECT_TRUE(prove_barrier_decrease(functions(1.0), problem, 0.0, 0.1).is_proved());
  EXPECT_LT(convergence_radius(functions(1.0), problem, 0.1), 1.25);
  ASSERT_NE(functions(1e160).beyond_range(problem.workspace), "");
  EXPECT_EQ(disturbance_margin(functions(1e160), problem).margin, 0.0);
  EXPECT_FALSE(prove_barrier_decrease(functions(1e160), problem, 0.0, 0.1).is_proved());
  EXPECT_EQ(convergence_radius(functions(1e160), problem, 0.1), std::numeric_limits<double>::infinity());
}

TEST(DisturbanceMargin, DoesNotDependOnTheNumberOfThreads) {
  use_threads(1);
  const DisturbanceMargin one = disturbance_margin(contracting(0.7), plain_problem());
  use_threads(2);
  const DisturbanceMargin two = disturbance_margin(contracting(0.7), plain_problem());
  EXPECT_EQ(one.margin, two.margin);
}

}  // namespace
}  // namespace s2nnds
