// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/problem/box.h"
#include "s2nnds/problem/interval.h"

namespace s2nnds {

// A closed form in n variables as a directed acyclic graph: nodes refer to earlier nodes only, equal nodes
// exist once, constant sub-expressions are folded. The function meant is the one whose literals are the
// doubles nearest to their decimal texts; what is computed from literals, such as 1/3, is exact in the
// enclosure and rounded in values.
class ExpressionTree {
 public:
  // What a node does. constant and variable have no argument, negate to tanh one, the others two.
  enum class Operation {
    constant,
    variable,
    negate,
    sin,
    cos,
    tan,
    exp,
    log,
    sqrt,
    abs,
    tanh,
    add,
    subtract,
    multiply,
    divide,
    power,
    min,
    max
  };
  // One constant, variable or operation.
  struct Node {
    Operation operation = Operation::constant;  // tells which members below count
    std::array<int, 2> arguments = {-1, -1};    // indices of earlier nodes; -1: none
    double value = 0.0;                         // of a constant, rounded
    Interval exact = 0.0;                       // of a constant: holds the exact value
    Eigen::Index axis = 0;                      // of a variable, from 0

    // The node's value if it is an integer constant of at most 1,000 in magnitude, else `otherwise`.
    int integer_or(int otherwise) const;
  };

  // A tree without nodes in n = `dimension` variables.
  explicit ExpressionTree(Eigen::Index dimension) : dimension_(dimension) {}

  // Like variable() and apply(), appends a node (or finds its equal) and returns its index. The node appended
  // last need not be the root.
  int constant(double value) { return constant(value, value); }
  // A constant whose exact value lies in `exact`; `value` is the one rounded to a double.
  int constant(double value, const Interval& exact);
  int variable(Eigen::Index axis);  // 0 <= axis < n
  // An operation on the nodes `first` and, where it has two arguments, `second`. Throws Error when a constant
  // sub-expression is not a finite number (1/0, log(-1)).
  int apply(Operation operation, int first, int second = -1);
  void set_root(int node) { root_ = node; }  // the node whose value is the expression's

  Eigen::Index dimension() const { return dimension_; }      // n
  const std::vector<Node>& nodes() const { return nodes_; }  // arguments come first
  int root() const { return root_; }                         // -1 before set_root()

  // Values at N points [N, n] -> [N]; NaN where the expression is not defined.
  Vector value(const Points& x) const;
  // Holds every value on the box [n] in exact arithmetic; undefined (NaN) where a value may not be defined.
  Interval enclosure(const Box& box) const;

 private:
  int find_or_append(const Node& node);

  Eigen::Index dimension_;
  std::vector<Node> nodes_;
  int root_ = -1;
};

}  // namespace s2nnds
