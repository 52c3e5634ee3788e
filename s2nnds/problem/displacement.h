// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/core/points.h"

namespace s2nnds {

// A change of coordinates that moves a ball by p as it is and leaves everything outside of a larger one alone:
//   T_p(x) = x + p psi(x),  psi(x) = S((outer - |x - center|) / (outer - inner)),
// psi = 1 within `inner` of the center, 0 beyond `outer`. S rises from 0 to 1 on [0, 1], twice continuously differentiable,
// with slopes of at most `slope`: they grow along a cubic over the first quarter, and fall so over the last one. So
// Lip(psi) = slope / (outer - inner), and for |p| Lip(psi) < 1 T_p is one-to-one from R^n onto R^n, and its inverse is
// differentiable too. States may have more coordinates than the center (a phase): those do not count and do not move.
class Displacement {
 public:
  static constexpr double slope = 4.0 / 3.0;  // the largest of S

  // Throws Error unless center [places] is finite and 0 <= inner < outer, finite.
  Displacement(const Vector& center, double inner, double outer);

  const Vector& center() const { return center_; }        // [places]
  double inner() const { return inner_; }                 // radius of what moves as it is
  double outer() const { return outer_; }                 // beyond which nothing changes
  Eigen::Index places() const { return center_.size(); }  // coordinates that move
  double lipschitz() const;                               // Lip(psi), rounded up
  double largest(double stretch) const;                   // |p| with |p| Lip(psi) <= stretch, rounded down

  // Below, states are [N, n] with n >= places, and p [places]. Throws Error on other shapes, and unless |p| Lip(psi) < 1.
  Vector bump(const Points& x) const;                    // psi(x), [N]
  Points image(const Points& y, const Vector& p) const;  // T_p(y)
  // T_p^-1(x), from s = psi(x - s p), which has one solution: the left side less the right one grows with s at a rate of
  // at least 1 - |p| Lip(psi). Newton's method kept within an interval, to rounding. Where nothing moves, x bit for bit.
  Points preimage(const Points& x, const Vector& p) const;
  // DT_p(y) v = v + p (grad psi(y) . v): how a velocity v at y is seen at T_p(y).
  Points pushed(const Points& y, const Points& v, const Vector& p) const;

 private:
  void check_shapes(const Points& x, const Vector& p) const;
  double value(const double* x) const;
  double derivative(const double* x, const double* direction) const;
  double share_moved(const double* x, const Vector& p) const;

  Vector center_;
  double inner_, outer_;
};

}  // namespace s2nnds
