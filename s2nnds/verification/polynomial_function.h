// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/problem/polynomial.h"
#include "s2nnds/verification/taylor_model.h"

namespace s2nnds {

// Polynomials R^n -> R^m as the prover sees them, a network's peer: so that published polynomial f, V, B can
// be judged by the same proof. What is meant are the polynomials with exactly these double coefficients.
class PolynomialFunction final : public TaylorFunction {
 public:
  // One polynomial an output. Throws Error if there are none, or if their dimensions differ.
  explicit PolynomialFunction(const std::vector<Polynomial>& outputs);

  Eigen::Index input_dimension() const override { return dimension_; }
  Eigen::Index output_dimension() const override { return static_cast<Eigen::Index>(outputs_.size()); }
  std::unique_ptr<Workspace> workspace() const override;
  void models(const BoxTile& tile, Workspace& workspace, TileModels& y) const override;
  void add_deviations(const BoxTile& tile, Workspace& workspace, const std::vector<TileRow>& adjoint,
                      TileForm& q) const override;
  void partial_models(const BoxTile& tile, Workspace& workspace, Eigen::Index axis,
                      TileModels& partials) const override;
  void gradient_models(const BoxTile& tile, Workspace& workspace, TileModels& gradient) const override;
  void add_value(const BoxTile& tile, Workspace& workspace, TileForm& q) const override;
  void add_derivative(const BoxTile& tile, Workspace& workspace, const TileModels& direction,
                      std::vector<TileRow>& adjoint, TileForm& q) const override;
  std::vector<IntervalMatrix> goal_factors(const TileRow& half) const override;
  std::vector<IntervalMatrix> goal_gradient_factors(const TileRow& half) const override;
  double growth(double reach) const override;
  bool vanishes_at_goal() const override;

 private:
  // A polynomial and its partial derivatives up to the fourth order. A coefficient is within 16 units in the
  // last place of the exact one (differentiation multiplies by whole numbers).
  struct Partial {
    std::vector<Eigen::Index> axes;  // differentiated along, ascending
    Vector coefficients;
    Eigen::MatrixXi exponents;
  };
  struct Memory;
  using Partials = std::vector<std::vector<Partial>>;  // by order 0, ..., 4

  static Partials partials_of(const Polynomial& polynomial, int orders);
  // The polynomial to second order on the tile; every rounding is in the remainder.
  void expand(const Partials& partials, const BoxTile& tile, Memory& memory, TileForm& form) const;
  // Encloses a partial derivative on the cube |x|_inf <= half.
  static Interval on_cube(const Partial& partial, double half);
  static bool vanishes_at_zero(const Partial& partial);

  Eigen::Index dimension_ = 0;
  int degree_ = 0;
  std::vector<Partials> outputs_;    // [m]
  std::vector<Partials> gradients_;  // [m, n], of every output
};

}  // namespace s2nnds
