// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/network_weights.h"
#include "s2nnds/verification/taylor_model.h"

namespace s2nnds {

// A layer stack as the prover sees it. Rounding errors are bounded a priori, for any order of summation and
// with or without fused operations: a computed sum of k products is within 2 (k + 4) u sum |products| of the
// exact one, u = 2^-53. The stack is copied; it is checked (throws Error).
class NetworkFunction final : public TaylorFunction {
 public:
  // Copies the weights. Throws Error when their shapes do not fit or a number is not finite.
  explicit NetworkFunction(const NetworkWeights& stack);

  Eigen::Index input_dimension() const override { return stack_.input_dimension(); }
  Eigen::Index output_dimension() const override { return stack_.output_dimension(); }
  std::unique_ptr<Workspace> workspace() const override;
  void models(const BoxTile& tile, Workspace& workspace, TileModels& y) const override;
  void add_deviations(const BoxTile& tile, Workspace& workspace, const std::vector<TileRow>& adjoint,
                      TileForm& q) const override;
  void partial_models(const BoxTile& tile, Workspace& workspace, Eigen::Index axis,
                      TileModels& partials) const override;
  void jacobian_models(const BoxTile& tile, Workspace& workspace, TileModels& y,
                       std::vector<TileModels>& partials) const override;
  void gradient_models(const BoxTile& tile, Workspace& workspace, TileModels& gradient) const override;
  void add_value(const BoxTile& tile, Workspace& workspace, TileForm& q) const override;
  void add_derivative(const BoxTile& tile, Workspace& workspace, const TileModels& direction,
                      std::vector<TileRow>& adjoint, TileForm& q) const override;
  std::vector<IntervalMatrix> goal_factors(const TileRow& half) const override;
  std::vector<IntervalMatrix> goal_gradient_factors(const TileRow& half) const override;
  bool is_positive_by_construction() const override;
  double growth(double reach) const override;
  bool vanishes_at_goal() const override;

 private:
  struct Memory;
  struct AffineMap {
    Points weight, magnitude;      // W and |W| [out, in]
    Vector bias;                   // [out]
    Vector row_error, bias_error;  // [out]
    double remainder_growth = 1.0, adjoint_rounding = 0.0;
  };

  Eigen::Index columns() const { return 1 + input_dimension() + triangle(input_dimension()); }
  void forward(const BoxTile& tile, const TileModels* direction, Memory& memory) const;
  // The same with the derivatives along all axes.
  void forward_along_axes(const BoxTile& tile, Memory& memory) const;
  // Takes as many streams as memory holds of x through the layers.
  void sweep(const BoxTile& tile, Memory& memory) const;
  // x into memory's first stream of some, the others 0.
  void start(const BoxTile& tile, Eigen::Index streams, Memory& memory) const;
  // From the outputs' adjoints in memory down to the inputs; those of the second stream are left in
  // `direction`.
  void backward(const BoxTile& tile, Memory& memory, std::vector<TileRow>* direction, TileForm& q) const;
  LayerTile layer_tile(const BoxTile& tile, std::size_t k, Memory& memory) const;
  // The Jacobian of the layers' output N over each of the cubes, [m, n].
  std::vector<IntervalMatrix> jacobians(const TileRow& half) const;
  void subtract_offset(Memory& memory) const;
  void clear_adjoint(Memory& memory) const;
  void norm_gradient(const BoxTile& tile, const Memory& memory, Eigen::Index axis,
                     TileModels& gradient) const;
  void add_norm(const BoxTile& tile, Memory& memory, TileForm& q) const;
  void add_norm_rate(const BoxTile& tile, const TileModels& direction, Memory& memory,
                     std::vector<TileRow>& adjoint, TileForm& q) const;

  NetworkWeights stack_;
  std::vector<AffineMap> maps_;
  Vector offset_, offset_error_;  // N(0) and its rounding error; 0 for the plain head
  double operations_ = 0.0;
};

}  // namespace s2nnds
