// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/polynomial.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_50;

const char* const kCubic = "1 + 2*x - 3*x*y + 0.7*y^2 - x^3 + 0.5*x^2*y^2";

Exact exact_value(const Polynomial& p, const Vector& x) {
  Exact sum = 0;
  for (Eigen::Index k = 0; k < p.terms(); ++k) {
    Exact term = p.coefficients()[k];
    for (Eigen::Index i = 0; i < p.dimension(); ++i) {
      for (int e = 0; e < p.exponents()(k, i); ++e) term *= Exact(x[i]);
    }
    sum += term;
  }
  return sum;
}

double at(const Polynomial& p, double x, double y) { return p.value(Points{{x, y}})[0]; }

TEST(Polynomial, ReadsTexts) {
  const Polynomial p = Polynomial::from_text(kCubic, 2);
  EXPECT_EQ(p.terms(), 6);
  EXPECT_EQ(p.degree(), 4);
  EXPECT_NEAR(at(p, 0.5, -2), 1 + 1 + 3 + 2.8 - 0.125 + 0.5, 1e-14);
  EXPECT_EQ(Polynomial::from_text("xi1^2*xi2 - 3", 2).degree(), 3);
  EXPECT_EQ(Polynomial::from_text("x - x", 2).terms(), 0);
  EXPECT_EQ(at(Polynomial::from_text("x - x", 2), 1, 2), 0);
}

TEST(Polynomial, ExpandsProducts) {
  const Polynomial p = Polynomial::from_text("(x + 2*y)^3/2 - (x - 1)*(x + 1)", 2);
  EXPECT_EQ(p.degree(), 3);
  EXPECT_NEAR(at(p, 0.3, -0.7), std::pow(0.3 - 1.4, 3) / 2 - (0.09 - 1), 1e-14);
  EXPECT_THROW(Polynomial::from_text("sin(x)", 2), Error);
  EXPECT_THROW(Polynomial::from_text("1/x", 2), Error);
  EXPECT_THROW(Polynomial::from_text("x^0.5", 2), Error);
  EXPECT_THROW(Polynomial::from_text("x^y", 2), Error);
}

TEST(Polynomial, DerivativesAndProductsObeyTheirRules) {
  const Polynomial p = Polynomial::from_text(kCubic, 2), q = Polynomial::from_text("x^2 - y + 2", 2);
  EXPECT_NEAR(at(p.derivative(0), 0.3, 0.4), 2 - 1.2 - 0.27 + 0.048, 1e-14);
  EXPECT_NEAR(at(p.derivative(1), 0.3, 0.4), -0.9 + 0.56 + 0.036, 1e-14);
  const Polynomial product_rule = p.derivative(0) * q + p * q.derivative(0) - (p * q).derivative(0);
  EXPECT_NEAR(at(product_rule, 0.9, -1.1), 0.0, 1e-13);
  EXPECT_EQ(Polynomial::constant(3.0, 2).derivative(1).terms(), 0);
}

TEST(Polynomial, EnclosureHoldsTheExactValue) {
  const Polynomial p = Polynomial::from_text(kCubic, 2);
  RandomStream random(1, "polynomial");
  for (int k = 0; k < 5000; ++k) {
    Box box{Vector(2), Vector(2)};
    Vector x(2);
    for (int i = 0; i < 2; ++i) {
      box.lower[i] = random.uniform(-2, 2);
      box.upper[i] = box.lower[i] + (random.uniform() < 0.1 ? 0.0 : std::pow(10.0, random.uniform(-9, 0)));
      x[i] = std::clamp(random.uniform(box.lower[i], box.upper[i]), box.lower[i], box.upper[i]);
    }
    const Interval bound = p.enclosure(box);
    const Exact exact = exact_value(p, x);
    ASSERT_TRUE(Exact(bound.lower) <= exact && exact <= Exact(bound.upper));
  }
}

TEST(Polynomial, ExcessOfTheEnclosureShrinksQuadratically) {
  const Polynomial p = Polynomial::from_text(kCubic, 2);
  const auto excess = [&](double h) {
    const Box box{Vector{{0.4 - h, -0.6 - h}}, Vector{{0.4 + h, -0.6 + h}}};
    Points grid(41 * 41, 2);
    for (int k = 0; k < grid.rows(); ++k) {
      grid.row(k) << 0.4 + h * (k % 41 - 20) / 20.0, -0.6 + h * (k / 41 - 20) / 20.0;
    }
    const Vector values = p.value(grid);
    return p.enclosure(box).width() - (values.maxCoeff() - values.minCoeff());
  };
  for (double h : {0.1, 0.05, 0.025}) EXPECT_LT(excess(h / 2), excess(h) / 3.5) << h;
  // A point's enclosure is as good as rounding allows.
  EXPECT_LT(p.enclosure({Vector{{0.4, -0.6}}, Vector{{0.4, -0.6}}}).width(), 1e-13);
}

TEST(Polynomial, UnboundedBoxes) {
  const double infinity = std::numeric_limits<double>::infinity();
  const Interval bound = Polynomial::from_text("x^2 + y^4 + 1", 2)
                             .enclosure({Vector{{-infinity, 2.0}}, Vector{{infinity, infinity}}});
  EXPECT_NEAR(bound.lower, 17.0, 1e-10);
  EXPECT_EQ(bound.upper, infinity);
}

TEST(Polynomial, ReadsPublishedFiles) {
  const std::string path = std::string(S2NNDS_SHARED_DATA) + "/abc_ds/Sine_unsafe_set_polynomial.json";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const Polynomial p = Polynomial::from_json(text, path, 2);
  EXPECT_EQ(p.terms(), 15);
  EXPECT_EQ(p.degree(), 4);
  EXPECT_NEAR(at(p, 0, 0), -4.3733104283548, 1e-13);
  EXPECT_NEAR(
      at(p, 0, 1),
      -4.3733104283548 - 0.5787378074019216 - 89.649464032155265 - 112.45337033985743 - 654.55640943331139,
      1e-10);
  EXPECT_NEAR(
      at(p, 1, 0),
      -4.3733104283548 - 102.65267411104287 - 598.80319565811078 - 1077.2838157954684 - 597.98300698244566,
      1e-9);
}

TEST(Polynomial, BadFilesAreNamed) {
  const std::string path = "polynomial_test.json";
  const auto message = [&](const std::string& content) -> std::string {
    try {
      Polynomial::from_json(content, path, 2);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  for (const char* content : {"", "{\"coefs\": [1]}", "{\"coefs\": [1, 2], \"monomials\": [\"1\"]}", "[1, 2]",
                              "{\"coefs\": [\"a\"], \"monomials\": [\"1\"]}"}) {
    EXPECT_NE(message(content).find(path), std::string::npos) << content << ": " << message(content);
  }
  EXPECT_NE(message("{\"coefs\": [1], \"monomials\": [\"xi(3)\"]}").find("xi3"), std::string::npos);
}

}  // namespace
}  // namespace s2nnds
