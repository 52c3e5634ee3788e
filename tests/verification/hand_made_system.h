// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/network_weights.h"
#include "s2nnds/problem/safety_problem.h"

// A system in n dimensions, the plane unless said otherwise, whose conditions are known to hold.
namespace s2nnds {

inline Layer layer(const Points& weight, const Vector& bias, Activation activation) {
  return {weight, bias, activation};
}

// xdot = A x.
inline NetworkWeights linear_field(const Points& a) {
  NetworkWeights f;
  f.layers = {layer(a, Vector(), Activation::identity)};
  f.head = Head::zero_at_origin;
  return f;
}
inline NetworkWeights stable_field(Eigen::Index n = 2) { return linear_field(-Points::Identity(n, n)); }

// |x|^2 + 0.05 |x|^2.
inline NetworkWeights quadratic_lyapunov(Eigen::Index n = 2) {
  NetworkWeights v;
  v.layers = {layer(Points::Identity(n, n), Vector(), Activation::identity)};
  v.head = Head::squared_norm;
  v.quadratic = 0.05;
  return v;
}

inline constexpr double barrier_edge = 0.8, barrier_gain = 4.0, barrier_level = 1.2;

// tanh(sum_i [2 + tanh(g (x_i - e)) - tanh(g (x_i + e))] - level): negative on a rounded cube, and along -x
// its derivative is negative everywhere but at 0.
inline NetworkWeights square_barrier(Eigen::Index n = 2) {
  Points inner = Points::Zero(2 * n, n), outer(1, 2 * n);
  Vector shift(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    inner(2 * i, i) = inner(2 * i + 1, i) = barrier_gain;
    shift(2 * i) = -barrier_gain * barrier_edge;
    shift(2 * i + 1) = barrier_gain * barrier_edge;
    outer(0, 2 * i) = 1.0;
    outer(0, 2 * i + 1) = -1.0;
  }
  NetworkWeights b;
  b.layers = {
      layer(inner, shift, Activation::tanh),
      layer(outer, Vector::Constant(1, 2.0 * static_cast<double>(n) - barrier_level), Activation::tanh),
      layer(Points::Identity(1, 1), Vector(), Activation::identity)};
  return b;
}

inline SafetyProblem simple_problem(Eigen::Index n = 2) {
  Vector start = Vector::Zero(n), obstacle = Vector::Zero(n);
  start.head(2) << 0.3, -0.2;
  obstacle.head(2) << 1.05, 1.05;
  SafetyProblem problem;
  problem.workspace = Box::cube(n, 1.25);
  problem.initial = ball(start, 0.2);
  problem.unsafe = ball(obstacle, 0.1);
  problem.workspace_margin = complement(box_region(Box::cube(n, 0.97 * 1.25)));
  return problem;
}

inline Networks simple_networks(Eigen::Index n = 2) {
  return {stable_field(n), quadratic_lyapunov(n), square_barrier(n)};
}

}  // namespace s2nnds
