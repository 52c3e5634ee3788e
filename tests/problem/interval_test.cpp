// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/interval.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <functional>

#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_50;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Of mixed magnitudes, so that tiny and wide intervals both occur.
Interval random_interval(RandomStream& random, double low, double high) {
  const double a = random.uniform(low, high);
  const double width = random.uniform() < 0.2 ? 0.0 : (high - a) * std::pow(10.0, -12.0 * random.uniform());
  return {a, std::min(high, a + width)};
}

double random_point(RandomStream& random, const Interval& a) {
  return std::clamp(random.uniform(a.lower, a.upper), a.lower, a.upper);
}

// True as well where nothing is said.
bool holds(const Interval& a, const Exact& x) {
  return !a.is_defined() || (Exact(a.lower) <= x && x <= Exact(a.upper));
}

struct Unary {
  const char* name;
  Interval (*enclosure)(const Interval&);
  Exact (*exact)(const Exact&);
  double low, high;
};

const Unary kUnary[] = {{"square", square, [](const Exact& x) -> Exact { return x * x; }, -3, 3},
                        {"abs", abs, [](const Exact& x) -> Exact { return abs(x); }, -3, 3},
                        {"sqrt", sqrt, [](const Exact& x) -> Exact { return sqrt(x); }, 0, 10},
                        {"exp", exp, [](const Exact& x) -> Exact { return exp(x); }, -30, 30},
                        {"log", log, [](const Exact& x) -> Exact { return log(x); }, 1e-9, 50},
                        {"sin", sin, [](const Exact& x) -> Exact { return sin(x); }, -12, 12},
                        {"cos", cos, [](const Exact& x) -> Exact { return cos(x); }, -12, 12},
                        {"tan", tan, [](const Exact& x) -> Exact { return tan(x); }, -5, 5},
                        {"tanh", tanh, [](const Exact& x) -> Exact { return tanh(x); }, -20, 20},
                        {"x^3", [](const Interval& a) { return power(a, 3); },
                         [](const Exact& x) -> Exact { return x * x * x; }, -3, 3},
                        {"x^4", [](const Interval& a) { return power(a, 4); },
                         [](const Exact& x) -> Exact { return pow(x, 4); }, -3, 3},
                        {"x^-2", [](const Interval& a) { return power(a, -2); },
                         [](const Exact& x) -> Exact { return 1 / (x * x); }, 0.1, 3},
                        {"x^(1/3)", [](const Interval& a) { return power(a, Interval(1.0) / Interval(3.0)); },
                         [](const Exact& x) -> Exact { return pow(x, Exact(1) / 3); }, 0, 5}};

TEST(Interval, UnaryFunctionsHoldTheExactValueOfEveryPoint) {
  RandomStream random(1, "interval");
  for (const Unary& f : kUnary) {
    for (int k = 0; k < 1500; ++k) {
      const Interval a = random_interval(random, f.low, f.high);
      const double x = random_point(random, a);
      ASSERT_TRUE(holds(f.enclosure(a), f.exact(Exact(x))))
          << f.name << " at " << x << " in " << a.lower << ", " << a.upper;
    }
  }
}

TEST(Interval, UnaryFunctionsOfAPointAreTight) {
  RandomStream random(2, "interval");
  for (const Unary& f : kUnary) {
    for (int k = 0; k < 500; ++k) {
      const double x = random.uniform(f.low, f.high);
      const Interval y = f.enclosure(x);
      // Near a maximum the enclosure of sin and cos ends at 1, which is no further off than rounding.
      EXPECT_LE(y.width(), 1e-13 * y.magnitude() + 1e-14) << f.name << " at " << x;
    }
  }
}

TEST(Interval, MonotoneFunctionsEncloseNoMoreThanTheRange) {
  const Interval e = exp(Interval(-1, 2));
  EXPECT_NEAR(e.lower, std::exp(-1.0), 1e-14);
  EXPECT_NEAR(e.upper, std::exp(2.0), 1e-13);
  const Interval s = sin(Interval(0.1, 3.0));
  EXPECT_NEAR(s.lower, std::sin(0.1), 1e-14);
  EXPECT_EQ(s.upper, 1.0);
  const Interval c = cos(Interval(2.0, 4.0));
  EXPECT_EQ(c.lower, -1.0);
  EXPECT_NEAR(c.upper, std::cos(2.0) > std::cos(4.0) ? std::cos(2.0) : std::cos(4.0), 1e-14);
  const Interval q = power(Interval(-2, 1), 4);
  EXPECT_EQ(q.lower, 0.0);
  EXPECT_NEAR(q.upper, 16.0, 1e-12);
}

TEST(Interval, ArithmeticHoldsTheExactValueAndIsTight) {
  RandomStream random(3, "interval");
  for (int k = 0; k < 20000; ++k) {
    const double scale = std::pow(10.0, random.uniform(-5, 5));
    const Interval a = random_interval(random, -scale, scale), b = random_interval(random, -2, 2);
    const double x = random_point(random, a), y = random_point(random, b);
    ASSERT_TRUE(holds(a + b, Exact(x) + y));
    ASSERT_TRUE(holds(a - b, Exact(x) - y));
    ASSERT_TRUE(holds(a * b, Exact(x) * y));
    ASSERT_TRUE(holds(a / b, Exact(x) / y));
    ASSERT_TRUE(holds(min(a, b), Exact(std::min(x, y))));
    ASSERT_TRUE(holds(max(a, b), Exact(std::max(x, y))));
    EXPECT_LE((Interval(x) * Interval(y)).width(), 1e-15 * std::abs(x * y));
    EXPECT_LE((Interval(x) / Interval(y)).width(), 1e-15 * std::abs(x / y));
  }
}

TEST(Interval, NextDoublesAreThoseOfTheLibrary) {
  RandomStream random(4, "interval");
  std::vector<double> values = {0.0,
                                -0.0,
                                1.0,
                                -1.0,
                                5e-324,
                                -5e-324,
                                2.2250738585072014e-308,
                                1.7976931348623157e308,
                                -1.7976931348623157e308,
                                -kInfinity};
  for (int k = 0; k < 1000; ++k)
    values.push_back(random.normal() * std::pow(10.0, random.uniform(-300, 300)));
  for (double x : values) {
    EXPECT_EQ(next_up(x), std::nextafter(x, kInfinity)) << x;
    EXPECT_EQ(next_down(-x), std::nextafter(-x, -kInfinity)) << x;
  }
  EXPECT_EQ(next_up(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(next_up(std::nan(""))));
}

TEST(Interval, OverflowKeepsAFiniteBound) {
  const Interval huge = Interval(1e300) * Interval(1e300);
  EXPECT_EQ(huge.lower, std::numeric_limits<double>::max());
  EXPECT_EQ(huge.upper, kInfinity);
  EXPECT_EQ(exp(Interval(1000.0)).lower, std::numeric_limits<double>::max());
  const Interval tiny = Interval(1e-300) * Interval(1e-300);
  EXPECT_EQ(tiny.lower, 0.0);
  EXPECT_GT(tiny.upper, 0.0);
}

TEST(Interval, UnboundedIntervalsStaySound) {
  const Interval half_line(2.0, kInfinity);
  EXPECT_EQ((half_line * Interval(0.0, 1.0)).lower, 0.0);
  EXPECT_EQ((half_line * Interval(0.0, 1.0)).upper, kInfinity);
  EXPECT_EQ((Interval(1.0) / half_line).lower, 0.0);
  EXPECT_NEAR((Interval(1.0) / half_line).upper, 0.5, 1e-15);
  EXPECT_EQ(sin(half_line).lower, -1.0);
  EXPECT_FALSE(tan(half_line).is_defined());
  EXPECT_NEAR(sqrt(half_line).lower, std::sqrt(2.0), 1e-15);
  EXPECT_EQ(tanh(half_line).upper, 1.0);
  EXPECT_EQ(power(half_line, Interval(-0.5)).lower, 0.0);
}

TEST(Interval, WhatIsNotDefinedSaysNothing) {
  for (const Interval& a :
       {sqrt(Interval(-1e-300, 1.0)), log(Interval(-1.0, 1.0)), power(Interval(-1.0, 1.0), Interval(0.5)),
        Interval::undefined() + 1.0, Interval::undefined() * 0.0, min(Interval::undefined(), 0.0),
        exp(Interval::undefined()), abs(Interval::undefined()), sin(Interval::undefined()),
        Interval(1.0) / Interval(-1.0, 1.0), Interval(1.0) / Interval(0.0, 1.0),
        Interval(0.0) / Interval(0.0), log(Interval(0.0, 1.0)), tan(Interval(1.0, 2.0)),
        power(Interval(-1.0, 1.0), -2), power(Interval(0.0, 4.0), Interval(-0.5))}) {
    EXPECT_FALSE(a.is_defined());
    EXPECT_FALSE(a.upper <= 0.0);
    EXPECT_FALSE(a.lower > 0.0);
  }
}

TEST(Interval, RealPowersAtZeroAndOfEitherSign) {
  const Interval root = power(Interval(0.0, 8.0), Interval(1.0) / Interval(3.0));
  EXPECT_EQ(root.lower, 0.0);
  EXPECT_NEAR(root.upper, 2.0, 1e-14);
  const Interval inverse = power(Interval(1.0, 4.0), Interval(-0.5));
  EXPECT_NEAR(inverse.lower, 0.5, 1e-15);
  EXPECT_NEAR(inverse.upper, 1.0, 1e-14);
  const Interval mixed = power(Interval(0.25, 4.0), Interval(-0.5, 0.5));
  EXPECT_NEAR(mixed.lower, 0.5, 1e-15);
  EXPECT_NEAR(mixed.upper, 2.0, 1e-14);
  EXPECT_TRUE(power(Interval(0.0), Interval(0.0)).contains(1.0));
}

}  // namespace
}  // namespace s2nnds
