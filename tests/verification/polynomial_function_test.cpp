// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/polynomial_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "s2nnds/verification/goal_neighbourhood.h"
#include "s2nnds/verification/network_function.h"
#include "s2nnds/verification/prover.h"
#include "tests/verification/exact_network.h"

namespace s2nnds {
namespace {

Polynomial random_polynomial(Eigen::Index n, RandomStream& random) {
  const Eigen::Index terms = 3 + static_cast<Eigen::Index>(random.below(8));
  Vector coefficients(terms);
  Eigen::MatrixXi exponents(terms, n);
  for (Eigen::Index k = 0; k < terms; ++k) {
    coefficients(k) = 3.0 * random.normal();
    for (Eigen::Index d = 0; d < n; ++d) exponents(k, d) = static_cast<int>(random.below(4));
  }
  return Polynomial(coefficients, exponents);
}

Exact exact_monomial(const Polynomial& p, Eigen::Index k, const ExactVector& x, Eigen::Index along) {
  Exact term = p.coefficients()(k);
  for (Eigen::Index d = 0; d < p.dimension(); ++d) {
    int power = p.exponents()(k, d);
    if (d == along) term *= power--;
    for (int i = 0; i < power; ++i) term *= x[d];
  }
  return term;
}
// along = -1: the value; else the partial derivative.
Exact exact_polynomial(const Polynomial& p, const ExactVector& x, Eigen::Index along) {
  Exact sum = 0;
  for (Eigen::Index k = 0; k < p.terms(); ++k) {
    if (along < 0 || p.exponents()(k, along) > 0) sum += exact_monomial(p, k, x, along);
  }
  return sum;
}

void random_tile(Eigen::Index n, double size, BoxTile& tile, Points& lower, Points& upper,
                 RandomStream& random) {
  lower.resize(tile_boxes, n);
  upper.resize(tile_boxes, n);
  for (Eigen::Index t = 0; t < tile_boxes; ++t) {
    for (Eigen::Index d = 0; d < n; ++d) {
      lower(t, d) = random.uniform(-1.5, 1.5);
      upper(t, d) = lower(t, d) + size * random.uniform();
    }
  }
  tile.assign(lower, upper, 0, tile_boxes);
}

TEST(PolynomialFunction, HoldsTheExactPolynomialAndItsLieDerivative) {
  RandomStream random(1, "polynomials");
  for (int k = 0; k < 1500; ++k) {
    const Eigen::Index n = 1 + static_cast<Eigen::Index>(random.below(3));
    std::vector<Polynomial> field;
    for (Eigen::Index d = 0; d < n; ++d) field.push_back(random_polynomial(n, random));
    const Polynomial p = random_polynomial(n, random);
    const PolynomialFunction f(field), y({p});
    ScalarEnclosure enclosure(y, &f);
    BoxTile tile(n);
    Points lower, upper;
    random_tile(n, std::pow(10.0, random.uniform(-8.0, 0.0)), tile, lower, upper, random);
    const TileForm value = enclosure.value(tile), rate = enclosure.lie_derivative(tile);
    for (Eigen::Index t = 0; t < tile_boxes; ++t) {
      ExactVector x;
      for (Eigen::Index d = 0; d < n; ++d) {
        x.push_back(Exact(lower(t, d)) + (Exact(upper(t, d)) - lower(t, d)) * double(random.below(5)) / 4.0);
      }
      Exact exact_rate = 0;
      for (Eigen::Index d = 0; d < n; ++d)
        exact_rate += exact_polynomial(p, x, d) * exact_polynomial(field[d], x, -1);
      const Exact exact = exact_polynomial(p, x, -1);
      ASSERT_LE(exact, value.upper(tile)(t));
      ASSERT_GE(exact, value.lower(tile)(t));
      ASSERT_LE(exact_rate, rate.upper(tile)(t));
      ASSERT_GE(exact_rate, rate.lower(tile)(t));
    }
  }
}

TEST(PolynomialFunction, RemaindersShrinkWithTheCubeOfTheBox) {
  RandomStream random(2, "tight");
  for (int k = 0; k < 20; ++k) {
    const PolynomialFunction f({random_polynomial(2, random), random_polynomial(2, random)});
    const PolynomialFunction y({random_polynomial(2, random)});
    ScalarEnclosure enclosure(y, &f);
    double previous = 0.0;
    for (double half : {0.02, 0.01, 0.005, 0.0025}) {
      const Points center = (Points(1, 2) << 0.7, -0.6).finished(), side = Points::Constant(1, 2, half);
      BoxTile tile(2);
      tile.assign(center - side, center + side, 0, 1);
      const double remainder = enclosure.lie_derivative(tile).remainder(0);
      if (previous > 1e-9) {
        EXPECT_LT(remainder, previous / 7.0);
      }
      previous = remainder;
    }
  }
}

// A polynomial V along a network's field: both kinds work together.
TEST(PolynomialFunction, ComposesWithNetworks) {
  RandomStream random(3, "mixed");
  for (int k = 0; k < 40; ++k) {
    const NetworkWeights stack = random_stack({2, 5, 5, 2}, Activation::tanh, Head::zero_at_origin, random);
    const NetworkFunction f(stack);
    const Polynomial p = random_polynomial(2, random);
    const PolynomialFunction y({p});
    ScalarEnclosure enclosure(y, &f);
    BoxTile tile(2);
    Points lower, upper;
    random_tile(2, 0.2, tile, lower, upper, random);
    const TileForm& rate = enclosure.lie_derivative(tile);
    for (Eigen::Index t = 0; t < tile_boxes; ++t) {
      const ExactVector x = {Exact(lower(t, 0)), Exact(upper(t, 1))};
      const ExactVector velocity = exact_network(stack, x, {0, 0}).value;
      const Exact exact = exact_polynomial(p, x, 0) * velocity[0] + exact_polynomial(p, x, 1) * velocity[1];
      ASSERT_LE(exact, rate.upper(tile)(t));
      ASSERT_GE(exact, rate.lower(tile)(t));
    }
  }
}

Polynomial quadratic(double xx, double xy, double yy, double constant) {
  return Polynomial((Vector(4) << xx, xy, yy, constant).finished(),
                    (Eigen::MatrixXi(4, 2) << 2, 0, 1, 1, 0, 2, 0, 0).finished());
}

ProofFunctions polynomial_system(double cubic) {
  // xdot = -x + cubic x^3, ydot = -y; V = x^2 + y^2 / 2; B = x^2 + y^2 - 1.
  const Polynomial fx((Vector(2) << -1.0, cubic).finished(),
                      (Eigen::MatrixXi(2, 2) << 1, 0, 3, 0).finished());
  const Polynomial fy(Vector::Constant(1, -1.0), (Eigen::MatrixXi(1, 2) << 0, 1).finished());
  return {std::make_shared<PolynomialFunction>(std::vector{fx, fy}),
          std::make_shared<PolynomialFunction>(std::vector{quadratic(1.0, 0.0, 0.5, 0.0)}),
          std::make_shared<PolynomialFunction>(std::vector{quadratic(1.0, 0.0, 1.0, -1.0)})};
}

SafetyProblem disc_problem() {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.25);
  problem.initial = ball(Vector::Constant(2, 0.3), 0.2);
  problem.unsafe = ball(Vector::Constant(2, 1.1), 0.1);
  return problem;
}

TEST(PolynomialFunction, IsProvedLikeANetwork) {
  const ProofResult result = prove(polynomial_system(0.5), disc_problem(), 0.01);
  EXPECT_EQ(result.guarantee, Guarantee::invariant);
  EXPECT_GT(result.goal_cube, 0.0);
  // 0.65 * 1.25^2 > 1: V grows near the workspace's left and right edges, and only there.
  const ProofResult wrong = prove(polynomial_system(0.65), disc_problem(), 0.01, ProofOptions::fail_fast());
  EXPECT_EQ(wrong[Condition::lyapunov_decrease].verdict.verdict, Verdict::refuted);
  EXPECT_GT(std::abs(wrong[Condition::lyapunov_decrease].verdict.witness[0]), 1.24);
  EXPECT_TRUE(wrong[Condition::barrier_decrease].is_proved());
}

// A linear term of 1e-17 makes V negative somewhere, however near the goal: that is what the coefficients
// say.
TEST(PolynomialFunction, TakesCoefficientsAtTheirWord) {
  ProofFunctions functions = polynomial_system(0.5);
  const Polynomial tilt(Vector::Constant(1, 1e-17), (Eigen::MatrixXi(1, 2) << 1, 0).finished());
  functions.V = std::make_shared<PolynomialFunction>(std::vector{quadratic(1.0, 0.0, 0.5, 0.0) + tilt});
  const ProofResult result = prove(functions, disc_problem(), 0.01, ProofOptions::fail_fast());
  EXPECT_NE(result[Condition::lyapunov_positive].verdict.verdict, Verdict::proved);
  EXPECT_LT(result[Condition::lyapunov_positive].open_upper.cwiseAbs().maxCoeff(), 1e-6);
}

std::vector<Polynomial> published(const nlohmann::json& result, const char* key) {
  const nlohmann::json& text = result.at(key);
  const std::vector<std::string> lines =
      text.is_array() ? text.get<std::vector<std::string>>() : std::vector{text.get<std::string>()};
  std::vector<Polynomial> polynomials;
  for (const std::string& line : lines) polynomials.push_back(Polynomial::from_text(line, 2));
  return polynomials;
}

// f = -x + k x^3 and V = |x|^2: f' lies in [-1, -1 + 3 k h^2] on |x| <= h, so that Vdot < 0 is seen below h = 1 / sqrt(3 k).
TEST(PolynomialFunction, GoalCubesAreTheLargestThatHold) {
  const auto cube = [](double k) {
    Vector coefficients(2);
    coefficients << -1.0, k;
    const Polynomial x(coefficients, (Eigen::MatrixXi(2, 2) << 1, 0, 3, 0).finished()),
        y(coefficients, (Eigen::MatrixXi(2, 2) << 0, 1, 0, 3).finished()),
        lyapunov(Vector::Ones(2), (Eigen::MatrixXi(2, 2) << 2, 0, 0, 2).finished());
    return decreasing_cube(PolynomialFunction({x, y}), PolynomialFunction({lyapunov}), 0.08);
  };
  EXPECT_EQ(cube(0.0), 0.08);
  EXPECT_EQ(cube(100.0), 0.04);         // 0.0577
  EXPECT_EQ(cube(1e8), 0.08 / 2048.0);  // 5.8e-5: the twelfth half
  EXPECT_EQ(cube(1e16), 0.0);           // 5.8e-9
}

// The published ABC-DS motion on PShape, on [-1, 1]^2: it goes through, and what fails has a witness.
TEST(PolynomialFunction, PublishedResultsGoThrough) {
  const std::string path = std::string(S2NNDS_SHARED_DATA) + "/abc_ds/PShape_result.json";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no data at " << path;
  std::ifstream file(path);
  const nlohmann::json result = nlohmann::json::parse(file);
  const ProofFunctions functions = {std::make_shared<PolynomialFunction>(published(result, "f_fh_str_arr")),
                                    std::make_shared<PolynomialFunction>(published(result, "V_fh_str_arr")),
                                    std::make_shared<PolynomialFunction>(published(result, "B_fh_str_arr"))};
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.0);
  problem.initial = ball((Vector(2) << -0.35, 0.05).finished(), 0.15);
  problem.unsafe = empty_region(2);
  const ProofResult proof = prove(functions, problem, 0.0, ProofOptions::fail_fast());
  EXPECT_TRUE(proof.side.goal_is_safe);
  EXPECT_LT(proof.seconds, 30.0);
  for (const ConditionProof& each : proof.conditions) {
    if (each.verdict.verdict != Verdict::refuted) continue;
    EXPECT_FALSE(each.verdict.witness.empty()) << to_string(each.verdict.condition);
  }
}

}  // namespace
}  // namespace s2nnds
