// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/core/points.h"
#include "s2nnds/problem/box.h"
#include "s2nnds/problem/interval.h"

namespace s2nnds {

// p(x) = sum_k coefficients_k prod_i x_i^exponents_ki in n variables. The polynomial meant is the one with
// these double coefficients.
class Polynomial {
 public:
  // coefficients [terms], exponents [terms, n] >= 0; equal monomials are added up, zero terms dropped. Throws
  // Error on sizes that do not match, coefficients that are not finite and exponents outside 0 to 1,000.
  Polynomial(const Vector& coefficients, const Eigen::MatrixXi& exponents);
  // One that has the same value everywhere, in n = `dimension` variables.
  static Polynomial constant(double value, Eigen::Index dimension);

  // From any closed form that is a polynomial, for example "0.5*x*y - (x - 1)^2" or the published ABC-DS
  // strings in xi1, xi2; products are expanded in doubles. Throws Error when it does not parse or is not a
  // polynomial.
  static Polynomial from_text(const std::string& text, Eigen::Index dimension);
  // From the text of a published file {"coefs": [...], "monomials": ["1", "xi(1)*xi(2)^2", ...]}. Throws Error
  // with the file's name, `path`.
  static Polynomial from_json(const std::string& text, const std::string& path, Eigen::Index dimension);

  Eigen::Index dimension() const { return exponents_.cols(); }  // n
  Eigen::Index terms() const { return coefficients_.size(); }   // 0 for the zero polynomial
  int degree() const;                                           // the largest total degree; 0 for a constant
  const Vector& coefficients() const { return coefficients_; }  // [terms]
  const Eigen::MatrixXi& exponents() const { return exponents_; }  // [terms, n]

  Vector value(const Points& x) const;  // [N, n] -> [N]
  // Holds every value on the box [n] in exact arithmetic. Taylor form around the box's centre (exact for a
  // polynomial), so that its excess shrinks quadratically with the box.
  Interval enclosure(const Box& box) const;
  Polynomial derivative(Eigen::Index axis) const;  // dp/dx_axis, axis from 0

  // Coefficients are rounded to nearest; throws Error on another dimension.
  Polynomial operator+(const Polynomial& other) const;
  Polynomial operator-(const Polynomial& other) const;  // as the sum
  Polynomial operator*(const Polynomial& other) const;  // expanded; as the sum
  Polynomial operator*(double factor) const;            // every coefficient times `factor`

 private:
  Vector coefficients_;
  Eigen::MatrixXi exponents_;
};

}  // namespace s2nnds
