// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/core/options.h"

namespace s2nnds {

// Choices of one fully connected network.
struct MlpOptions {
  std::vector<std::int64_t> hidden = {64, 64, 64};
  std::string activation = "tanh";  // of the hidden layers
  std::string output_activation = "identity";
  bool bias = true;
  double first_layer_gain = 1.0;  // the first layer's start, times Xavier's
  double first_layer_bias = 0.0;  // its biases start as N(0, this^2)

  void visit(FieldVisitor& v);
};

// The dynamics f: R^n -> R^n with f(0) = 0.
//   zero_at_origin: f(x) = g(x) - g(0), g a network with biases (profile robust);
//   otherwise: f = g, a network without biases (profile paper). With odd activations f(-x) = -f(x), so that
//     motions that pass through x and -x cannot be fitted.
struct VectorFieldOptions {
  MlpOptions network = {.first_layer_gain = 4.0, .first_layer_bias = 1.0};
  bool zero_at_origin = true;

  void visit(FieldVisitor& v);
};

// The Lyapunov function V: R^n -> R with V(0) = 0.
//   squared_norm: V(x) = |phi(x) - phi(0)|^2 + quadratic |x|^2 (profile robust): V > 0 and grad V(0) = 0 by
//     construction;
//   scalar: V = phi, a network without biases (profile paper). In general grad V(0) is not 0, so V < 0
//     somewhere arbitrarily near the goal, which samples may miss.
struct LyapunovOptions {
  MlpOptions network = {.hidden = {64, 64}};
  std::string form = "squared_norm";
  std::int64_t features = 32;  // outputs of phi (squared_norm)
  double quadratic = 0.05;     // eps_V (squared_norm)

  void visit(FieldVisitor& v);
};

// The barrier function B: R^n -> R; {B <= 0} is the safe set. A steep first layer lets {B = 0} turn sharp
// corners, so that it follows obstacles, and motions that pass them closely, at a small distance.
struct BarrierOptions {
  MlpOptions network = {.first_layer_gain = 4.0, .first_layer_bias = 1.0};

  void visit(FieldVisitor& v);
};

struct NetworkOptions {
  VectorFieldOptions f;
  LyapunovOptions V;
  BarrierOptions B;

  void visit(FieldVisitor& v);
};

// The shapes and starts of the paper's networks: no biases in f and V, tanh f, ELU V and B.
NetworkOptions paper_networks();

}  // namespace s2nnds
