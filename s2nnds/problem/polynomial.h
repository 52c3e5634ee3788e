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
  // coefficients [terms], exponents [terms, n] >= 0; equal monomials are added up, zero terms dropped.
  Polynomial(const Vector& coefficients, const Eigen::MatrixXi& exponents);
  static Polynomial constant(double value, Eigen::Index dimension);

  // From any closed form that is a polynomial, for example "0.5*x*y - (x - 1)^2" or the published ABC-DS
  // strings in xi1, xi2; products are expanded in doubles. Throws Error when it does not parse or is not a
  // polynomial.
  static Polynomial from_text(const std::string& text, Eigen::Index dimension);
  // From a published file {"coefs": [...], "monomials": ["1", "xi(1)*xi(2)^2", ...]}. Throws Error with its
  // path.
  static Polynomial from_json_file(const std::string& path, Eigen::Index dimension);

  Eigen::Index dimension() const { return exponents_.cols(); }
  Eigen::Index terms() const { return coefficients_.size(); }
  int degree() const;  // the largest total degree; 0 for a constant
  const Vector& coefficients() const { return coefficients_; }
  const Eigen::MatrixXi& exponents() const { return exponents_; }

  Vector value(const Points& x) const;  // [N, n] -> [N]
  // Holds every value on the box [n] in exact arithmetic. Taylor form around the box's centre (exact for a
  // polynomial), so that its excess shrinks quadratically with the box.
  Interval enclosure(const Box& box) const;
  Polynomial derivative(Eigen::Index axis) const;

  Polynomial operator+(const Polynomial& other) const;
  Polynomial operator-(const Polynomial& other) const;
  Polynomial operator*(const Polynomial& other) const;
  Polynomial operator*(double factor) const;

 private:
  Vector coefficients_;
  Eigen::MatrixXi exponents_;
};

}  // namespace s2nnds
