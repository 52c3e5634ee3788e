// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/expression_tree.h"

#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

using Operation = ExpressionTree::Operation;
using Node = ExpressionTree::Node;
using Column = Eigen::ArrayXd;

constexpr int kNotAnInteger = std::numeric_limits<int>::max();
constexpr Eigen::Index kTile = 1024;  // points at a time, so that the columns of all nodes stay in cache

constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

// The domains are those of the intervals, where doubles would go on with infinity: 1/0, log(0), 0^-1 are undefined, and
// so is a power of a negative number unless the exponent is written as an integer.
double quotient(double a, double b) { return b == 0.0 ? kUndefined : a / b; }
double logarithm(double a) { return a > 0.0 ? std::log(a) : kUndefined; }
double power_of(double base, double exponent, bool integer) {
  if (base == 0.0 && exponent < 0.0) return kUndefined;
  return base < 0.0 && !integer ? kUndefined : std::pow(base, exponent);
}

// min and max keep NaN, so that an undefined piece is noticed.
double least(double a, double b) { return std::isnan(a) || a < b ? a : b; }

Interval enclose(const Node& node, const Interval& a, const Interval& b, const Node* exponent) {
  switch (node.operation) {
    case Operation::constant:
      return node.exact;
    case Operation::variable:
      break;
    case Operation::negate:
      return -a;
    case Operation::sin:
      return sin(a);
    case Operation::cos:
      return cos(a);
    case Operation::tan:
      return tan(a);
    case Operation::exp:
      return exp(a);
    case Operation::log:
      return log(a);
    case Operation::sqrt:
      return sqrt(a);
    case Operation::abs:
      return abs(a);
    case Operation::tanh:
      return tanh(a);
    case Operation::add:
      return a + b;
    case Operation::subtract:
      return a - b;
    case Operation::multiply:
      return node.arguments[0] == node.arguments[1] ? square(a) : a * b;
    case Operation::divide:
      return a / b;
    case Operation::power: {
      const int integer = exponent->integer_or(kNotAnInteger);
      return integer == kNotAnInteger ? power(a, b) : power(a, integer);
    }
    case Operation::min:
      return min(a, b);
    case Operation::max:
      return max(a, b);
  }
  return Interval::undefined();
}

Column evaluate(const Node& node, const Column& a, const Column& b, const Node& second) {
  switch (node.operation) {
    case Operation::constant:
    case Operation::variable:
      break;
    case Operation::negate:
      return -a;
    case Operation::sin:
      return a.sin();
    case Operation::cos:
      return a.cos();
    case Operation::tan:
      return a.tan();
    case Operation::exp:
      return a.exp();
    case Operation::log:
      return a.unaryExpr([](double x) { return logarithm(x); });
    case Operation::sqrt:
      return a.sqrt();
    case Operation::abs:
      return a.abs();
    case Operation::tanh:
      return a.tanh();
    case Operation::add:
      return a + b;
    case Operation::subtract:
      return a - b;
    case Operation::multiply:
      return a * b;
    case Operation::divide:
      return a.binaryExpr(b, [](double x, double y) { return quotient(x, y); });
    case Operation::power: {
      const bool integer = second.integer_or(kNotAnInteger) != kNotAnInteger;
      return a.binaryExpr(
          b, [integer](double base, double exponent) { return power_of(base, exponent, integer); });
    }
    case Operation::min:
      return a.binaryExpr(b, [](double x, double y) { return least(x, y); });
    case Operation::max:
      return a.binaryExpr(b, [](double x, double y) { return -least(-x, -y); });
  }
  return {};
}

}  // namespace

int ExpressionTree::Node::integer_or(int otherwise) const {
  const bool integer = operation == Operation::constant && exact.is_point() && std::abs(value) <= 1000.0 &&
                       value == std::round(value);
  return integer ? static_cast<int>(value) : otherwise;
}

int ExpressionTree::find_or_append(const Node& node) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& other = nodes_[i];
    if (other.operation == node.operation && other.arguments == node.arguments && other.axis == node.axis &&
        other.value == node.value && other.exact.lower == node.exact.lower &&
        other.exact.upper == node.exact.upper) {
      return static_cast<int>(i);
    }
  }
  nodes_.push_back(node);
  return static_cast<int>(nodes_.size()) - 1;
}

int ExpressionTree::constant(double value, const Interval& exact) {
  return find_or_append({.value = value, .exact = exact});
}

int ExpressionTree::variable(Eigen::Index axis) {
  check(axis >= 0 && axis < dimension_, "expression: variable {} in dimension {}", axis + 1, dimension_);
  return find_or_append({.operation = Operation::variable, .axis = axis});
}

int ExpressionTree::apply(Operation operation, int first, int second) {
  const Node node{.operation = operation, .arguments = {first, second}};
  const Node& a = nodes_[static_cast<std::size_t>(first)];
  const Node& b = nodes_[static_cast<std::size_t>(second < 0 ? first : second)];
  if (a.operation != Operation::constant || b.operation != Operation::constant) return find_or_append(node);
  const double value = evaluate(node, Column::Constant(1, a.value), Column::Constant(1, b.value), b)[0];
  const Interval exact = enclose(node, a.exact, b.exact, &b);
  check(std::isfinite(value) && exact.is_defined(),
        "expression: a constant part of it has no finite value ({})", value);
  return constant(value, exact);
}

Vector ExpressionTree::value(const Points& x) const {
  check(x.cols() == dimension_, "expression: points of dimension {}, expected {}", x.cols(), dimension_);
  Vector result(x.rows());
  std::vector<Column> columns(nodes_.size());
  for (Eigen::Index start = 0; start < x.rows(); start += kTile) {
    const Eigen::Index count = std::min(kTile, x.rows() - start);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      if (node.operation == Operation::constant) {
        columns[i] = Column::Constant(count, node.value);
      } else if (node.operation == Operation::variable) {
        columns[i] = x.col(node.axis).segment(start, count);
      } else {
        const auto second = static_cast<std::size_t>(std::max(node.arguments[1], 0));
        columns[i] = evaluate(node, columns[static_cast<std::size_t>(node.arguments[0])], columns[second],
                              nodes_[second]);
      }
    }
    result.segment(start, count) = columns[static_cast<std::size_t>(root_)];
  }
  return result;
}

Interval ExpressionTree::enclosure(const Box& box) const {
  check(box.dimension() == dimension_, "expression: box of dimension {}, expected {}", box.dimension(),
        dimension_);
  std::vector<Interval> intervals(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    if (node.operation == Operation::variable) {
      intervals[i] = Interval(box.lower[node.axis], box.upper[node.axis]);
      continue;
    }
    const auto first = static_cast<std::size_t>(std::max(node.arguments[0], 0));
    const auto second = static_cast<std::size_t>(std::max(node.arguments[1], 0));
    intervals[i] = enclose(node, intervals[first], intervals[second], &nodes_[second]);
  }
  return intervals[static_cast<std::size_t>(root_)];
}

}  // namespace s2nnds
