// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/core/options.h"

namespace s2nnds {

// Choices of one fully connected network.
struct MlpOptions {
  std::vector<std::int64_t> hidden = {64, 64, 64};  // neurons of each hidden layer, 1 to 4,096
  std::string activation = "tanh";                  // of the hidden layers
  std::string output_activation = "identity";       // of the last layer
  bool bias = true;                                 // whether the layers have biases
  double first_layer_gain = 1.0;  // the first layer's weights start as Xavier's times this, > 0
  double first_layer_bias = 0.0;  // >= 0: its biases start as N(0, this^2), all others as 0

  void visit(FieldVisitor& v);  // names every key
};

// The dynamics f: R^n -> R^n with f(0) = 0.
//   zero_at_origin: f(x) = g(x) - g(0), g a network with biases (profile robust);
//   otherwise: f = g, a network without biases (profile paper). With odd activations f(-x) = -f(x), so that
//     motions that pass through x and -x cannot be fitted.
struct VectorFieldOptions {
  MlpOptions network = {.first_layer_gain = 4.0, .first_layer_bias = 1.0};  // g
  bool zero_at_origin = true;  // f(x) = g(x) - g(0); where false, `bias` must be false too
  // plain: x' = f(x); projected: x' is the velocity nearest to f(x) along which V falls at least as fast as
  // e^(-decay t), so that every motion converges whatever f is; V must be a diffeomorphism. auto: projected in
  // five and more dimensions, where no proof is in reach, unless verification.method is proof or [execution] is
  // given; else plain
  std::string form = "auto";
  double decay = 0.1;  // projected: kappa, 1 / normalised time, > 0

  double projection() const { return form == "projected" ? decay : 0.0; }  // kappa of a projected f, else 0
  void visit(FieldVisitor& v);  // names the keys of `network` and its own
};

// The Lyapunov function V: R^n -> R with V(0) = 0.
//   diffeomorphism: V(x) = |x + g(x) - g(0)|^2, g a network n -> n with a Lipschitz constant below 1. Then
//     x -> x + g(x) - g(0) is one-to-one from R^n onto R^n, so V > 0 and grad V != 0 away from the goal;
//   squared_norm: V(x) = |phi(x) - phi(0)|^2 + quadratic |x|^2 (profile robust): V > 0 and grad V(0) = 0 by
//     construction;
//   scalar: V = phi, a network without biases (profile paper). In general grad V(0) is not 0, so V < 0
//     somewhere arbitrarily near the goal, which samples may miss.
struct LyapunovOptions {
  MlpOptions network = {.hidden = {32, 32}};  // phi
  // squared_norm: V(x) = |phi(x) - phi(0)|^2 + quadratic |x|^2; scalar: V = phi, `bias` must be false;
  // diffeomorphism: V(x) = |x + phi(x) - phi(0)|^2, phi with `lipschitz`, not silu; auto: diffeomorphism where f is
  // projected, else squared_norm
  std::string form = "auto";
  std::int64_t features = 16;  // squared_norm: outputs of phi, 1 to 4,096
  double quadratic = 0.05;     // squared_norm: the weight of |x|^2, eps_V, > 0
  // diffeomorphism: the product of the layers' spectral norms, which is at least the Lipschitz constant of phi, is
  // kept below this in training; in (0, 1)
  double lipschitz = 0.95;

  void visit(FieldVisitor& v);  // names the keys of `network` and its own
};

// The barrier function B: R^n -> R; {B <= 0} is the safe set. A steep first layer lets {B = 0} turn sharp
// corners, so that it follows obstacles, and motions that pass them closely, at a small distance.
struct BarrierOptions {
  // B itself
  MlpOptions network = {.hidden = {48, 48, 48}, .first_layer_gain = 4.0, .first_layer_bias = 1.0};
  // >= 0, in 1 / normalised length, 0: none. In the plane, where the first layer has tanh and biases, one neuron for each side of
  // the box that is to hold {B <= 0} begins along that side, so steep: {B <= 0} comes closer to it. Elsewhere not in use; in
  // space such a B took more rounds to certify.
  double wall_slope = 12.0;

  void visit(FieldVisitor& v);  // names the keys of `network` and its own
};

// The three networks of a run.
struct NetworkOptions {
  VectorFieldOptions f;  // vector field
  LyapunovOptions V;     // Lyapunov function
  BarrierOptions B;      // barrier function

  // Replaces the forms that are auto; `projected` says which f is meant by it.
  void choose_forms(bool projected);
  void visit(FieldVisitor& v);  // names the groups f, V, B
};

// The shapes and starts of the paper's networks: no biases in f and V, tanh f, ELU V and B.
NetworkOptions paper_networks();

}  // namespace s2nnds
