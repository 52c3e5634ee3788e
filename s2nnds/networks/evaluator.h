// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/fused_network.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// A NetworkWeights made ready for many evaluations: weights packed once, N(0) computed once. T is the
// precision of the arithmetic: double for what is verified, float where a search or a hint for training is
// all that is wanted.
template <typename T>
class BasicEvaluator {
 public:
  explicit BasicEvaluator(const NetworkWeights& stack);  // throws Error if the stack is not consistent

  Eigen::Index input_dimension() const { return network_.inputs(); }  // n
  // m: 1 for sums of squares.
  Eigen::Index output_dimension() const { return is_sum_of_squares(head_) ? 1 : network_.outputs(); }

  // As NetworkWeights::value; throws Error on a wrong shape.
  Points value(const Points& x) const;
  // The same of points that lie in memory of somebody else's, without a copy of them.
  Points value(const Eigen::Map<const Points>& x) const;
  // As NetworkWeights::value_and_derivative; throws Error on a wrong shape.
  void value_and_derivative(const Points& x, const Points& direction, Points& value,
                            Points& derivative) const;
  // As NetworkWeights::value_and_gradient, by one reverse sweep; throws Error on a wrong shape, and unless m = 1.
  void value_and_gradient(const Points& x, Vector& value, Points& gradient) const;

 private:
  using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  // Of N(x) [rows, outputs] at x: less N(0), and more x for a diffeomorphism.
  template <typename Rows>
  void finish(const Rows& x, Matrix& raw) const;

  FusedNetwork<T> network_;
  Head head_;
  double quadratic_;
  Matrix at_origin_;  // [1, outputs]: N(0), for all heads but plain
};
// What verification and evaluation use.
using Evaluator = BasicEvaluator<double>;

}  // namespace s2nnds
