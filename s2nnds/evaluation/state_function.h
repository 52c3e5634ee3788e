// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <concepts>
#include <functional>
#include <utility>

#include "s2nnds/networks/dynamics.h"

namespace s2nnds {

// What is evaluated: any function of the state, a network, the velocity of dynamics, or a callable that maps N points [N, n] to N values
// [N, m]. A vector field f has m = n, a barrier function B has m = 1. It must bear calls from several threads
// at once. All of them convert to it, so that functions which take one are called with either.
class StateFunction {
 public:
  StateFunction(const NetworkWeights& network);  // packs the weights once; throws Error as check() does
  StateFunction(const Dynamics& dynamics);       // the velocity; otherwise alike
  // From a callable Points -> Points, which is copied.
  template <typename F>
  requires std::is_invocable_r_v<Points, const F&, const Points&> StateFunction(F function)
      : value_(std::move(function)), quick_value_(value_) {}

  // In double: [N, n] -> [N, m].
  Points value(const Points& x) const { return value_(x); }
  // Networks in single precision, several times as fast: for labels, where a rounding error may turn a few.
  // The same as value() for a callable.
  Points quick_value(const Points& x) const { return quick_value_(x); }

 private:
  std::function<Points(const Points&)> value_;
  std::function<Points(const Points&)> quick_value_;
};

// Throws Error, naming `where`, unless the function maps the point [n] to [outputs].
void check_outputs(const StateFunction& function, const Vector& point, Eigen::Index outputs,
                   const char* where);

}  // namespace s2nnds
