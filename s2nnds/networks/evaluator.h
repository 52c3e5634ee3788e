#pragma once

#include "s2nnds/networks/fused_network.h"
#include "s2nnds/networks/layer_stack.h"

namespace s2nnds {

// A LayerStack made ready for many evaluations in double precision: weights packed once, N(0) computed once.
class Evaluator {
 public:
  explicit Evaluator(const LayerStack& stack);  // throws Error if the stack is not consistent

  Eigen::Index input_dimension() const { return network_.inputs(); }
  Eigen::Index output_dimension() const { return head_ == Head::squared_norm ? 1 : network_.outputs(); }

  // As the functions of LayerStack; throw Error on a wrong shape.
  Points value(const Points& x) const;
  void value_and_derivative(const Points& x, const Points& direction, Points& value,
                            Points& derivative) const;

 private:
  FusedNetwork<double> network_;
  Head head_;
  double quadratic_;
  Eigen::RowVectorXd at_origin_;  // N(0), for anchored and squared_norm
};

}  // namespace s2nnds
