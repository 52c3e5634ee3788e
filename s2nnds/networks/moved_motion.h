// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/dynamics.h"
#include "s2nnds/problem/displacement.h"

namespace s2nnds {

// Velocity, Lyapunov function and barrier of networks in a scene of which a ball has been displaced by p. With y = T_p^-1(x):
//   f_p(x) = DT_p(y) f(y) + psi(y) p',  V_p(x) = V(y),  B_p(x) = B(y).
// x(t) = T_p(t)(y(t)) is a motion of f_p if and only if y(t) is one of f, whatever p(t) is, so what is proved of all motions
// of f holds of all motions of f_p, of the sets as T_p shows them. Normalised units; p' is the displacement's velocity.
class MovedMotion {
 public:
  // Throws Error as the networks' evaluators do, and unless the displacement moves n coordinates or the first of n.
  MovedMotion(const Networks& networks, const Displacement& displacement);

  // Of states x [N, n], displacement p [places] and its velocity `rate` [places]. Throws Error as Displacement does.
  Points velocity(const Points& x, const Vector& p) const;  // [N, n], of a scene at rest
  Points velocity(const Points& x, const Vector& p, const Vector& rate) const;
  Points lyapunov(const Points& x, const Vector& p) const;  // [N, 1]
  Points barrier(const Points& x, const Vector& p) const;   // [N, 1]

  // T_p, as given
  const Displacement& displacement() const { return displacement_; }

 private:
  BasicDynamicsEvaluator<double> f_;
  Evaluator V_, B_;
  Displacement displacement_;
};

}  // namespace s2nnds
