// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/polynomial.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/expression.h"

namespace s2nnds {
namespace {

using Operation = ExpressionTree::Operation;

constexpr int kHighestDegree = 1000;
constexpr Eigen::Index kLargestTaylorForm =
    100000;  // coefficients; beyond it the terms are bounded one by one

// Coefficients in the order of std::map's keys, the exponents.
using Terms = std::map<std::vector<int>, double>;

Terms collect(const Vector& coefficients, const Eigen::MatrixXi& exponents) {
  Terms terms;
  for (Eigen::Index k = 0; k < coefficients.size(); ++k) {
    std::vector<int> key(static_cast<std::size_t>(exponents.cols()));
    for (Eigen::Index i = 0; i < exponents.cols(); ++i) key[static_cast<std::size_t>(i)] = exponents(k, i);
    terms[key] += coefficients[k];
  }
  std::erase_if(terms, [](const auto& term) { return term.second == 0.0; });
  return terms;
}

Polynomial monomial(Eigen::Index axis, Eigen::Index dimension) {
  Eigen::MatrixXi exponents = Eigen::MatrixXi::Zero(1, dimension);
  exponents(0, axis) = 1;
  return Polynomial(Vector::Ones(1), exponents);
}

Polynomial raise(const Polynomial& base, int exponent) {
  Polynomial result = Polynomial::constant(1.0, base.dimension());
  for (int k = 0; k < exponent; ++k) result = result * base;
  return result;
}

// The polynomial of one node, given those of the nodes before it.
Polynomial expand(const ExpressionTree& tree, const ExpressionTree::Node& node,
                  const std::vector<Polynomial>& before, const std::string& text) {
  if (node.operation == Operation::constant) return Polynomial::constant(node.value, tree.dimension());
  if (node.operation == Operation::variable) return monomial(node.axis, tree.dimension());
  const auto second = static_cast<std::size_t>(std::max(node.arguments[1], 0));
  const Polynomial& a = before[static_cast<std::size_t>(node.arguments[0])];
  const Polynomial& b = before[second];
  const ExpressionTree::Node& b_node = tree.nodes()[second];
  switch (node.operation) {
    case Operation::negate:
      return a * -1.0;
    case Operation::add:
      return a + b;
    case Operation::subtract:
      return a - b;
    case Operation::multiply:
      return a * b;
    case Operation::divide:
      check(b_node.operation == Operation::constant, "polynomial \"{}\": division by something that varies",
            text);
      return a * (1.0 / b_node.value);
    case Operation::power: {
      const int exponent = b_node.integer_or(-1);
      check(exponent >= 0 && a.degree() * exponent <= kHighestDegree,
            "polynomial \"{}\": expected whole exponents >= 0 and a degree of at most {}", text,
            kHighestDegree);
      return raise(a, exponent);
    }
    default:
      fail("polynomial \"{}\": expected sums, products and whole powers only", text);
  }
}

// a(x) -> a(center + x) along one axis of a dense array of coefficients, by repeated synthetic division.
void shift(std::vector<Interval>& a, std::size_t size, std::size_t stride, const Interval& center) {
  for (std::size_t line = 0; line < a.size(); ++line) {
    if ((line / stride) % size != 0) continue;  // not the start of a line along this axis
    for (std::size_t k = 0; k + 1 < size; ++k) {
      for (std::size_t j = size - 1; j-- > k;) a[line + j * stride] += center * a[line + (j + 1) * stride];
    }
  }
}

// Powers of one interval, up to `degree`.
std::vector<Interval> powers(const Interval& base, int degree) {
  std::vector<Interval> result;
  for (int k = 0; k <= degree; ++k) result.push_back(power(base, k));
  return result;
}

// The terms bounded one by one: for unbounded boxes.
Interval natural_form(const Polynomial& p, const Box& box) {
  Interval sum = 0.0;
  for (Eigen::Index k = 0; k < p.terms(); ++k) {
    Interval term = p.coefficients()[k];
    for (Eigen::Index i = 0; i < p.dimension(); ++i) {
      if (p.exponents()(k, i) > 0) term *= power(Interval(box.lower[i], box.upper[i]), p.exponents()(k, i));
    }
    sum += term;
  }
  return sum;
}

}  // namespace

Polynomial::Polynomial(const Vector& coefficients, const Eigen::MatrixXi& exponents) {
  check(coefficients.size() == exponents.rows() && exponents.cols() > 0,
        "polynomial: {} coefficients and exponents [{}, {}]", coefficients.size(), exponents.rows(),
        exponents.cols());
  check(coefficients.allFinite(), "polynomial: a coefficient is not a finite number");
  check(exponents.size() == 0 || (exponents.minCoeff() >= 0 && exponents.maxCoeff() <= kHighestDegree),
        "polynomial: expected exponents from 0 to {}", kHighestDegree);
  const Terms terms = collect(coefficients, exponents);
  coefficients_.resize(static_cast<Eigen::Index>(terms.size()));
  exponents_.resize(coefficients_.size(), exponents.cols());
  Eigen::Index k = 0;
  for (const auto& [key, coefficient] : terms) {
    coefficients_[k] = coefficient;
    for (Eigen::Index i = 0; i < exponents_.cols(); ++i) exponents_(k, i) = key[static_cast<std::size_t>(i)];
    ++k;
  }
}

Polynomial Polynomial::constant(double value, Eigen::Index dimension) {
  return Polynomial(Vector::Constant(1, value), Eigen::MatrixXi::Zero(1, dimension));
}

Polynomial Polynomial::from_text(const std::string& text, Eigen::Index dimension) {
  const ExpressionTree tree = parse_expression(text, dimension);
  std::vector<Polynomial> expanded;
  for (int i = 0; i <= tree.root(); ++i) {
    expanded.push_back(expand(tree, tree.nodes()[static_cast<std::size_t>(i)], expanded, text));
  }
  return expanded.back();
}

Polynomial Polynomial::from_json(const std::string& text, const std::string& path, Eigen::Index dimension) {
  try {
    const nlohmann::json content = nlohmann::json::parse(text);
    const auto coefficients = content.at("coefs").get<std::vector<double>>();
    const auto monomials = content.at("monomials").get<std::vector<std::string>>();
    check(coefficients.size() == monomials.size() && !monomials.empty(),
          "polynomial: {}: {} coefs and {} monomials, expected as many of both, at least one", path,
          coefficients.size(), monomials.size());
    Polynomial sum = constant(0.0, dimension);
    for (std::size_t k = 0; k < monomials.size(); ++k) {
      sum = sum + from_text(monomials[k], dimension) * coefficients[k];
    }
    return sum;
  } catch (const nlohmann::json::exception& error) {
    fail("polynomial: {}: expected JSON with the keys coefs and monomials: {}", path, error.what());
  }
}

int Polynomial::degree() const { return terms() == 0 ? 0 : exponents_.rowwise().sum().maxCoeff(); }

Vector Polynomial::value(const Points& x) const {
  check(x.cols() == dimension(), "polynomial: points of dimension {}, expected {}", x.cols(), dimension());
  std::vector<Eigen::ArrayXXd> axis_powers;  // of each axis [N, degree + 1]
  for (Eigen::Index i = 0; i < dimension(); ++i) {
    const int degree = terms() == 0 ? 0 : exponents_.col(i).maxCoeff();
    Eigen::ArrayXXd table = Eigen::ArrayXXd::Ones(x.rows(), degree + 1);
    for (int k = 1; k <= degree; ++k) table.col(k) = table.col(k - 1) * x.col(i).array();
    axis_powers.push_back(std::move(table));
  }
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(x.rows());
  for (Eigen::Index k = 0; k < terms(); ++k) {
    Eigen::ArrayXd term = Eigen::ArrayXd::Constant(x.rows(), coefficients_[k]);
    for (Eigen::Index i = 0; i < dimension(); ++i) {
      if (exponents_(k, i) > 0) term *= axis_powers[static_cast<std::size_t>(i)].col(exponents_(k, i));
    }
    sum += term;
  }
  return sum;
}

Interval Polynomial::enclosure(const Box& box) const {
  check(box.dimension() == dimension(), "polynomial: box of dimension {}, expected {}", box.dimension(),
        dimension());
  if (terms() == 0) return 0.0;
  const Eigen::VectorXi sizes = exponents_.colwise().maxCoeff().transpose().array() + 1;
  double count = 1.0;
  for (int size : sizes) count *= size;
  if (!box.is_finite() || !(count <= kLargestTaylorForm)) return natural_form(*this, box);

  // p(center + d) = sum_k a_k d^k, the last axis running fastest.
  std::vector<Interval> a(static_cast<std::size_t>(count), Interval(0.0));
  for (Eigen::Index k = 0; k < terms(); ++k) {
    std::size_t index = 0;
    for (Eigen::Index i = 0; i < dimension(); ++i) {
      index = index * static_cast<std::size_t>(sizes[i]) + static_cast<std::size_t>(exponents_(k, i));
    }
    a[index] = coefficients_[k];
  }
  const Vector center = box.center();
  std::vector<std::vector<Interval>> offsets;  // powers of x - center
  std::size_t stride = a.size();
  for (Eigen::Index i = 0; i < dimension(); ++i) {
    const auto size = static_cast<std::size_t>(sizes[i]);
    stride /= size;
    shift(a, size, stride, center[i]);
    offsets.push_back(powers(Interval(box.lower[i], box.upper[i]) - center[i], sizes[i] - 1));
  }
  Interval sum = 0.0;
  for (std::size_t index = 0; index < a.size(); ++index) {
    Interval term = a[index];
    std::size_t rest = index;
    for (Eigen::Index i = dimension(); i-- > 0;) {
      const auto size = static_cast<std::size_t>(sizes[i]);
      if (rest % size > 0) term *= offsets[static_cast<std::size_t>(i)][rest % size];
      rest /= size;
    }
    sum += term;
  }
  return sum;
}

Polynomial Polynomial::derivative(Eigen::Index axis) const {
  check(axis >= 0 && axis < dimension(), "polynomial: derivative along axis {} of {}", axis, dimension());
  const Vector coefficients = coefficients_.cwiseProduct(exponents_.col(axis).cast<double>());
  Eigen::MatrixXi exponents = exponents_;
  exponents.col(axis) = (exponents.col(axis).array() - 1).max(0);
  return Polynomial(coefficients, exponents);
}

Polynomial Polynomial::operator+(const Polynomial& other) const {
  check(other.dimension() == dimension(), "polynomial: dimension {} plus dimension {}", dimension(),
        other.dimension());
  Vector coefficients(terms() + other.terms());
  coefficients << coefficients_, other.coefficients_;
  Eigen::MatrixXi exponents(coefficients.size(), dimension());
  exponents << exponents_, other.exponents_;
  return Polynomial(coefficients, exponents);
}

Polynomial Polynomial::operator-(const Polynomial& other) const { return *this + other * -1.0; }

Polynomial Polynomial::operator*(const Polynomial& other) const {
  check(other.dimension() == dimension(), "polynomial: dimension {} times dimension {}", dimension(),
        other.dimension());
  Vector coefficients(terms() * other.terms());
  Eigen::MatrixXi exponents(coefficients.size(), dimension());
  for (Eigen::Index j = 0, row = 0; j < terms(); ++j) {
    for (Eigen::Index k = 0; k < other.terms(); ++k, ++row) {
      coefficients[row] = coefficients_[j] * other.coefficients_[k];
      exponents.row(row) = exponents_.row(j) + other.exponents_.row(k);
    }
  }
  return Polynomial(coefficients, exponents);
}

Polynomial Polynomial::operator*(double factor) const {
  return Polynomial(coefficients_ * factor, exponents_);
}

}  // namespace s2nnds
