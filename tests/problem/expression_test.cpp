// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/expression.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <functional>
#include <optional>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_50;

double value(const std::string& text, std::vector<double> x) {
  const Points point = Eigen::Map<const Points>(x.data(), 1, static_cast<Eigen::Index>(x.size()));
  return parse_expression(text, point.cols()).value(point)[0];
}

std::string message(const std::string& text, Eigen::Index dimension = 2) {
  try {
    parse_expression(text, dimension);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

Box random_box(RandomStream& random, double reach, double largest) {
  Box box{Vector(2), Vector(2)};
  for (int i = 0; i < 2; ++i) {
    box.lower[i] = random.uniform(-reach, reach);
    box.upper[i] = box.lower[i] + largest * std::pow(10.0, -6.0 * random.uniform());
  }
  return box;
}

TEST(Expression, Arithmetic) {
  EXPECT_DOUBLE_EQ(value("1 + 2*x - y/4", {3, 2}), 6.5);
  EXPECT_DOUBLE_EQ(value("max(x, y, 0.5) - min(x, y)", {-1, 0}), 1.5);
  EXPECT_DOUBLE_EQ(value("2e-1*x1 + .5*x2 + 1E1", {1, 2}), 11.2);
  EXPECT_DOUBLE_EQ(value("x - -2*(y)", {1, 2}), 5);
  EXPECT_DOUBLE_EQ(value("sin(x) + cos(y) + tan(0.3) + pi", {0.4, 0.2}),
                   std::sin(0.4) + std::cos(0.2) + std::tan(0.3) + 3.141592653589793);
  EXPECT_DOUBLE_EQ(value("exp(log(2)) + sqrt(abs(x)) + tanh(y)", {-4, 0}), 4);
  EXPECT_DOUBLE_EQ(value("x1 + 10*x2 + 100*x3 + 1000*xi4 + 10000*xi(2)", {1, 2, 3, 4}), 24321);
  EXPECT_DOUBLE_EQ(value("x + 10*y + 100*z", {1, 2, 3}), 321);
  EXPECT_DOUBLE_EQ(value("3.5", {0, 0}), 3.5);
  EXPECT_DOUBLE_EQ(value("x\n + y", {1, 2}), 3);
}

TEST(Expression, PowersBindTighterThanMinus) {
  for (const char* power : {"^", "**"}) {
    const std::string p = power;
    EXPECT_DOUBLE_EQ(value("-x" + p + "2", {3, 0}), -9);
    EXPECT_DOUBLE_EQ(value("-2" + p + "2 + x", {0, 0}), -4);
    EXPECT_DOUBLE_EQ(value("2*x" + p + "2*y", {3, 2}), 36);
    EXPECT_DOUBLE_EQ(value("x" + p + "2 + y" + p + "2", {3, 4}), 25);
    EXPECT_DOUBLE_EQ(value("2" + p + "3" + p + "2 + 0*x", {0, 0}), 512);  // from the right, as in mathematics
    EXPECT_DOUBLE_EQ(value("x" + p + "-1", {4, 0}), 0.25);
    EXPECT_DOUBLE_EQ(value("(-x)" + p + "3", {2, 0}), -8);
  }
}

TEST(Expression, RootsOfSquaresWorkAtZero) {
  const std::string text = "(((x+0.3)/6)**2)**(1/3) + (((y-0.4)/3)**2)**(1/3) - 0.15";
  EXPECT_DOUBLE_EQ(value(text, {-0.3, 0.4}), -0.15);
  const Interval at_cusp = parse_expression(text, 2).enclosure({Vector{{-0.31, 0.4}}, Vector{{-0.29, 0.4}}});
  EXPECT_TRUE(at_cusp.contains(-0.15));
  EXPECT_LT(at_cusp.lower, -0.15 + 1e-12);
  EXPECT_NEAR(at_cusp.upper, std::cbrt(1e-4 / 36) - 0.15, 1e-12);
}

TEST(Expression, MistakesAreToldOnOneLine) {
  try {
    parse_expression("x +\x01\x7f\n y", 2);
    FAIL();
  } catch (const Error& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("expression \"x +??  y\": ")) << error.what();
  }
}

TEST(Expression, MistakesAreNamed) {
  EXPECT_NE(message("2x").find("unexpected 'x'"), std::string::npos) << message("2x");
  EXPECT_NE(message("x + ").find("does not parse"), std::string::npos);
  EXPECT_NE(message("").find("does not parse"), std::string::npos);
  EXPECT_NE(message("max(x, y").find("does not parse"), std::string::npos);
  EXPECT_NE(message("x y").find("unexpected 'y'"), std::string::npos);
  EXPECT_NE(message("w + 1").find("unknown name 'w'"), std::string::npos);
  EXPECT_NE(message("z").find("unknown name 'z'"), std::string::npos);
  EXPECT_NE(message("x0").find("unknown name 'x0'"), std::string::npos);
  EXPECT_NE(message("xi(3)").find("unknown name 'xi3'"), std::string::npos);
  EXPECT_NE(message("sinh(x)").find("unknown function 'sinh'"), std::string::npos);
  EXPECT_NE(message("sin(x, y)").find("2 arguments, expected 1"), std::string::npos);
  EXPECT_NE(message("max(x)").find("1 arguments, expected at least 2"), std::string::npos);
  EXPECT_NE(message("x if y else 1").find("unexpected 'if'"), std::string::npos);
  EXPECT_NE(message("x <= y").find("unexpected character '<'"), std::string::npos);
  EXPECT_NE(message("x // y").find("unexpected '/'"), std::string::npos);
  EXPECT_NE(message("x # y").find("unexpected character"), std::string::npos);
  EXPECT_NE(message("\xce\xb1 + x").find("outside ASCII"), std::string::npos);
  EXPECT_NE(message("1e999*x").find("within range"), std::string::npos);
  EXPECT_NE(message("3j + x").find("unexpected 'j'"), std::string::npos);
  EXPECT_NE(message("0x10 + x").find("unexpected 'x10'"), std::string::npos);
  EXPECT_NE(message("x + 1/0").find("no finite value"), std::string::npos);
  EXPECT_NE(message("log(-1)*x").find("no finite value"), std::string::npos);
  EXPECT_NE(message("x.y").find("unexpected '.'"), std::string::npos) << message("x.y");
  EXPECT_NE(message("sin(x=y)").find("unexpected character '='"), std::string::npos);
  EXPECT_NE(message("x, y").find("unexpected ','"), std::string::npos);
  EXPECT_NE(message(std::string(4000, '(') + "x" + std::string(4000, ')')).find("nested"), std::string::npos);
  std::string tower = "x";
  for (int k = 0; k < 4000; ++k) tower += "^x";
  EXPECT_NE(message(tower).find("nested"), std::string::npos);
  EXPECT_NE(message(std::string(20000, '1')).find("at most"), std::string::npos);
  for (const std::string text :
       {"2x",       "x +",  "sinh(x)", "(",          ")",      "max(", "*",    "x**",    "()",    "x(1)",
        "lambda x", "x\n+", "+x",      "max(x, y,)", "xi(-1)", "xi(1", "2(3)", "(x)(y)", "1.5.2", "2e"}) {
    const std::string found = message(text);
    EXPECT_FALSE(found.empty()) << text;
    EXPECT_EQ(found.find('\n'), std::string::npos) << found;
  }
}

TEST(Expression, LongTextsWithinTheBoundsAreRead) {
  EXPECT_DOUBLE_EQ(value(std::string(9000, '-') + "x", {3, 0}), 3);
  EXPECT_DOUBLE_EQ(value(std::string(200, '(') + "x" + std::string(200, ')'), {3, 0}), 3);
  std::string sum = "x";
  for (int k = 1; k < 4000; ++k) sum += "+x";
  EXPECT_DOUBLE_EQ(value(sum, {0.5, 0}), 2000);
}

TEST(Expression, EqualPartsAreSharedAndConstantsFolded) {
  const ExpressionTree tree = parse_expression("(x + y)*(x + y) + 2*3", 2);
  EXPECT_LE(tree.nodes().size(), 8u);
  // A product of equal factors is a square, which is never negative.
  EXPECT_EQ(parse_expression("(x + y)*(x + y)", 2).enclosure(Box::cube(2, 1.0)).lower, 0.0);
}

TEST(Expression, EnclosureHoldsTheExactValue) {
  const ExpressionTree wave = parse_expression("y + 0.2*sin(9.5*x - pi/6) - 0.5", 2);
  const ExpressionTree astroid =
      parse_expression("(((x+0.3)/6)**2)**(1/3) + (((y-0.4)/3)**2)**(1/3) - 0.15", 2);
  const Exact pi = boost::math::constants::pi<Exact>();
  const auto cube_root_of_square = [](const Exact& u) -> Exact { return pow(u * u, Exact(1) / 3); };
  RandomStream random(1, "expression");
  for (int k = 0; k < 3000; ++k) {
    const Box box = random_box(random, 1.3, 1.0);
    const Exact x = std::clamp(random.uniform(box.lower[0], box.upper[0]), box.lower[0], box.upper[0]);
    const Exact y = std::clamp(random.uniform(box.lower[1], box.upper[1]), box.lower[1], box.upper[1]);
    const Exact exact_wave = y + Exact(0.2) * sin(Exact(9.5) * x - pi / 6) - Exact(0.5);
    const Exact exact_astroid =
        cube_root_of_square((x + Exact(0.3)) / 6) + cube_root_of_square((y - Exact(0.4)) / 3) - Exact(0.15);
    const Interval w = wave.enclosure(box), a = astroid.enclosure(box);
    ASSERT_TRUE(Exact(w.lower) <= exact_wave && exact_wave <= Exact(w.upper));
    ASSERT_TRUE(Exact(a.lower) <= exact_astroid && exact_astroid <= Exact(a.upper));
  }
}

// A random expression as text, and its exact value at a point: nothing where it is undefined.
struct RandomTree {
  std::string text;
  std::function<std::optional<Exact>(const Exact&, const Exact&)> exact;
};

RandomTree random_tree(RandomStream& random, int depth) {
  using Value = std::optional<Exact>;
  if (depth == 0 || random.uniform() < 0.15) {
    static const char* constants[] = {"0", "1", "2", "-1", "0.5", "3", "-2.5"};
    const std::size_t choice = random.below(9);
    if (choice == 0) return {"x", [](const Exact& x, const Exact&) -> Value { return x; }};
    if (choice == 1) return {"y", [](const Exact&, const Exact& y) -> Value { return y; }};
    const std::string text = constants[choice - 2];
    return {"(" + text + ")", [c = Exact(text)](const Exact&, const Exact&) -> Value { return c; }};
  }
  const RandomTree a = random_tree(random, depth - 1);
  using Unary = std::function<Value(const Exact&)>;
  static const std::vector<std::pair<std::string, Unary>> functions = {
      {"sin", [](const Exact& v) -> Value { return sin(v); }},
      {"cos", [](const Exact& v) -> Value { return cos(v); }},
      {"exp", [](const Exact& v) -> Value { return exp(v); }},
      {"tanh", [](const Exact& v) -> Value { return tanh(v); }},
      {"abs", [](const Exact& v) -> Value { return abs(v); }},
      {"log", [](const Exact& v) { return v > 0 ? Value(log(v)) : Value(); }},
      {"sqrt", [](const Exact& v) { return v >= 0 ? Value(sqrt(v)) : Value(); }},
      {"-", [](const Exact& v) -> Value { return -v; }}};
  if (random.uniform() < 0.4) {
    const auto& [name, function] = functions[random.below(functions.size())];
    return {name + "(" + a.text + ")", [a, function = function](const Exact& x, const Exact& y) {
              const Value inner = a.exact(x, y);
              return inner ? function(*inner) : Value();
            }};
  }
  const RandomTree b = random_tree(random, depth - 1);
  const std::size_t choice = random.below(7);
  const int whole = static_cast<int>(random.below(7)) - 3;
  if (choice == 6) {  // an integer written down
    return {fmt::format("({})^({})", a.text, whole), [a, whole](const Exact& x, const Exact& y) {
              const Value base = a.exact(x, y);
              if (!base || (*base == 0 && whole < 0)) return Value();
              return Value(whole == 0 ? Exact(1) : pow(*base, whole));
            }};
  }
  static const std::string format[] = {"({}+{})", "({}-{})",    "({}*{})",
                                       "({}/{})", "max({},{})", "min({},{})"};
  return {fmt::format(fmt::runtime(format[choice]), a.text, b.text),
          [a, b, choice](const Exact& x, const Exact& y) {
            const Value u = a.exact(x, y), v = b.exact(x, y);
            if (!u || !v || (choice == 3 && *v == 0)) return Value();
            const Exact results[] = {*u + *v,           *u - *v,
                                     *u * *v,           choice == 3 ? *u / *v : Exact(0),
                                     *u < *v ? *v : *u, *u < *v ? *u : *v};
            return Value(results[choice]);
          }};
}

// What is undefined somewhere is neither inside nor outside, whatever is made of it: max(y/y, tanh(2.8)) at y = 0.
TEST(Expression, RandomTreesAreDefinedWhereTheExactOnesAre) {
  RandomStream random(5, "random-tree");
  int undefined = 0, defined = 0;
  for (int tree = 0; tree < 4000; ++tree) {
    const RandomTree made = random_tree(random, 4);
    std::optional<ExpressionTree> parsed;
    try {
      parsed = parse_expression(made.text, 2);
    } catch (const Error&) {
      continue;  // a constant part without a value
    }
    for (int k = 0; k < 6; ++k) {
      Vector point(2);
      for (int i = 0; i < 2; ++i)
        point[i] = random.below(3) == 0 ? 0.0 : std::round(8.0 * random.uniform(-2.0, 2.0)) / 8.0;
      Box box{point, point};
      if (k % 2 == 1) box = {point.array() - random.uniform(), point.array() + random.uniform()};
      const std::optional<Exact> exact = made.exact(Exact(point[0]), Exact(point[1]));
      const Interval enclosure = parsed->enclosure(box);
      const double rounded = parsed->value(point.transpose())[0];
      if (!exact) {
        ++undefined;
        ASSERT_FALSE(enclosure.is_defined()) << made.text << " at " << point.transpose();
      } else if (enclosure.is_defined()) {
        ++defined;
        ASSERT_TRUE(Exact(enclosure.lower) <= *exact && *exact <= Exact(enclosure.upper))
            << made.text << " at " << point.transpose() << ": [" << enclosure.lower << ", " << enclosure.upper
            << "]";
        ASSERT_TRUE(k % 2 == 1 || std::isfinite(rounded) || abs(*exact) > 1e300) << made.text;
      }
    }
  }
  EXPECT_GT(undefined, 500);
  EXPECT_GT(defined, 5000);
}

TEST(Expression, ValuesAreUndefinedWhereInfinityWouldBeLost) {
  for (const std::string text : {"tanh(1/x)", "exp(log(x))", "max(y/x, tanh(2.8))", "1/(x^(-1))",
                                 "min(1, 1/x)", "(0*y-2)^y", "exp(-1/abs(x))"}) {
    EXPECT_TRUE(std::isnan(value(text, {0.0, 2.0}))) << text;
  }
}

TEST(Expression, EnclosureIsTheRangeWhereEachVariableOccursOnce) {
  const ExpressionTree tree = parse_expression("max(y, -4*x - 0.8)", 2);
  const Interval range = tree.enclosure({Vector{{-0.5, -2.0}}, Vector{{-0.25, 0.5}}});
  EXPECT_NEAR(range.lower, 0.2, 1e-14);
  EXPECT_NEAR(range.upper, 1.2, 1e-14);
}

}  // namespace
}  // namespace s2nnds
