// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/networks/activation.h"

namespace s2nnds {

std::string_view to_string(Activation activation);  // its name: "tanh"
Activation activation_from(std::string_view name);  // throws Error that lists the names there are
std::vector<std::string> activation_names();        // of all activations

// a = activation(weight * z + bias)
struct Layer {
  Points weight;                                 // [out, in]
  Vector bias;                                   // [out], or empty: no bias
  Activation activation = Activation::identity;  // of all its neurons
};

// What is made of the layers' output N(x).
enum class Head {
  plain,           // y = N(x)
  zero_at_origin,  // y = N(x) - N(0), so that y(0) = 0 exactly
  // y = |N(x) - N(0)|^2 + quadratic |x|^2: y(0) = 0, grad y(0) = 0, y > 0 elsewhere if quadratic > 0
  squared_norm,
  // y = |x + N(x) - N(0)|^2, m = n: y(0) = 0, and y > 0 elsewhere where N is a contraction
  diffeomorphism,
};
// Whether y is a sum of squares, so that m = 1 whatever the layers have.
inline bool is_sum_of_squares(Head head) {
  return head == Head::squared_norm || head == Head::diffeomorphism;
}
std::string_view to_string(Head head);  // its name: "plain"
Head head_from(std::string_view name);  // throws Error that lists the names there are

// A network as numbers: the plain double snapshot that verification, evaluation and export see. It is what a
// certificate speaks of.
struct NetworkWeights {
  std::vector<Layer> layers;  // from input to output; at least one
  Head head = Head::plain;    // what is made of their output
  double quadratic = 0.0;     // >= 0, for squared_norm only

  Eigen::Index input_dimension() const;   // n; 0 without layers
  Eigen::Index output_dimension() const;  // m: 1 for sums of squares; 0 without layers
  std::size_t parameter_count() const;    // numbers in all weights and biases
  void check() const;                     // throws Error on mismatched shapes or non-finite weights

  // y(x) for N points [N, n] -> [N, m], double precision.
  Points value(const Points& x) const;
  // y(x) and its derivative along `direction` [N, n]: d/ds y(x + s direction) at s = 0.
  void value_and_derivative(const Points& x, const Points& direction, Points& value,
                            Points& derivative) const;
  // y(x) [N] and its gradient [N, n], m = 1.
  void value_and_gradient(const Points& x, Vector& value, Points& gradient) const;
};

struct Dynamics;  // dynamics.h

// The three networks of a run, and what moves by them: x' = velocity(x).
struct Networks {
  NetworkWeights f;  // vector field, n -> n
  NetworkWeights V;  // Lyapunov function, n -> 1
  NetworkWeights B;  // barrier function, n -> 1
  // kappa >= 0: the velocity is the one nearest to f(x) along which V falls at least as fast as e^(-kappa t)
  // (Dynamics); 0: it is f(x).
  double decay = 0.0;

  bool is_projected() const { return decay > 0.0; }  // whether the velocity may differ from f(x)
  Dynamics dynamics() const;                         // a copy of what the velocity depends on
  Points velocity(const Points& x) const;            // [N, n] -> [N, n], double precision
};

// SHA-256, in hexadecimal, of heads, activations, shapes and weights (little-endian doubles) of f, V, B in
// this order, and of the decay where there is one.
std::string weight_hash(const Networks& networks);

}  // namespace s2nnds
