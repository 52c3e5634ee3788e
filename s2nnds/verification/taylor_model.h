// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/verification/interval_matrix.h"
#include "s2nnds/verification/taylor_kernels.h"

namespace s2nnds {

// One double for each box of a tile, aligned for the widest registers.
struct alignas(64) TileRow : Eigen::Array<double, tile_boxes, 1> {
  using Base = Eigen::Array<double, tile_boxes, 1>;  // [T]
  TileRow() : Base(Base::Zero()) {}                  // zero in every lane
  // The value of an array expression of T numbers.
  template <typename Derived>
  TileRow(const Eigen::ArrayBase<Derived>& other) : Base(other) {}  // NOLINT: an expression is a row
  using Base::operator=;
};

// Up to T = tile_boxes boxes |x - center| <= half of R^n; lanes that are not filled repeat the last box.
class BoxTile {
 public:
  // All lanes are the origin, without extent.
  explicit BoxTile(Eigen::Index dimension) : center(dimension), half(dimension) {}

  Eigen::Index dimension() const { return static_cast<Eigen::Index>(center.size()); }  // n
  // Rows first, ..., first + count - 1 of `lower` and `upper` [N, n]; 0 < count <= tile_boxes. Centres are
  // rounded, half-widths are rounded up, so that each box is covered. Throws Error on another count or
  // dimension.
  void assign(const Points& lower, const Points& upper, Eigen::Index first, Eigen::Index count);

  std::vector<TileRow> center,  // [n] midpoints
      half;                     // [n] half-widths, >= 0
};

// Number of entries of the upper triangle of a symmetric n x n matrix: n (n + 1) / 2.
inline Eigen::Index triangle(Eigen::Index n) { return n * (n + 1) / 2; }

// The place of entry (i, j), i <= j < n, among them, row by row from 0.
inline Eigen::Index triangle_row(Eigen::Index i, Eigen::Index j, Eigen::Index n) {
  return i * n - i * (i - 1) / 2 + (j - i);
}

// Second-order Taylor models of m functions on a tile, dx = x - c:
//   |y_i(x) - value_i - slope_i . dx - dx' H_i dx / 2| <= remainder_i.
struct TileModels {
  // Models of m = `outputs` functions of n = `inputs` variables, all zero.
  TileModels(Eigen::Index outputs, Eigen::Index inputs)
      : dimension(inputs), models(outputs * columns()), remainder(outputs) {}

  // Coefficients of a model: its value, n slopes and the upper triangle of its Hessian.
  Eigen::Index columns() const { return 1 + dimension + triangle(dimension); }
  TileRow& value(Eigen::Index i) { return models[i * columns()]; }                     // y_i at the centre
  TileRow* slope(Eigen::Index i) { return &models[i * columns() + 1]; }                // [n]
  TileRow* hessian(Eigen::Index i) { return &models[i * columns() + 1 + dimension]; }  // [n (n + 1) / 2]
  // y_i at the centre.
  const TileRow& value(Eigen::Index i) const { return models[i * columns()]; }
  const TileRow* slope(Eigen::Index i) const { return &models[i * columns() + 1]; }  // [n]
  // [n (n + 1) / 2]
  const TileRow* hessian(Eigen::Index i) const { return &models[i * columns() + 1 + dimension]; }
  // Above |slope_i . dx|.
  TileRow spread(Eigen::Index i, const BoxTile& tile) const;
  // Above |y_i(x) - value_i - slope_i . dx|: the deviation from the first-order model.
  TileRow deviation(Eigen::Index i, const BoxTile& tile) const;

  Eigen::Index dimension;          // n
  std::vector<TileRow> models;     // [m, columns]
  std::vector<TileRow> remainder;  // [m]
};

// Above |slope . dx| on each box: slope [n].
TileRow linear_size(const TileRow* slope, const BoxTile& tile);
// Above |dx' H dx / 2| on each box: hessian [n (n + 1) / 2], the upper triangle of H row by row.
TileRow quadratic_size(const TileRow* hessian, const BoxTile& tile);

// A scalar function to third order on a tile: |q(x) - value - gradient . dx - dx' H dx / 2 - C(dx)| <= remainder, dx = x - c,
// C(dx) the sum of cubic[d, e g] dx_d dx_e dx_g over d and e <= g, once the roundings collected in `magnitude` are counted (bounds do).
struct TileForm {
  // The form 0 in n = `dimension` variables.
  explicit TileForm(Eigen::Index dimension)
      : gradient(dimension), hessian(triangle(dimension)), cubic(dimension * triangle(dimension)) {}
  void clear();  // back to the form 0
  TileForm negative() const;
  // One lane becomes another's of a form in as many variables.
  void take(const TileForm& other, Eigen::Index lane, Eigen::Index to);
  // Adds value + slope . dx, slope [n].
  void add_line(const TileRow& line_value, const TileRow* slope, const BoxTile& tile);
  // Adds weight dx' H dx / 2, H given by the rows of its upper triangle.
  void add_curvature(const TileRow& weight, const std::vector<TileRow>& rows, const BoxTile& tile);

  // Adds (slope . dx) (dx' H dx / 2): slope [n], hessian [n (n + 1) / 2], the upper triangle of H row by row.
  void add_cubic(const TileRow* slope, const TileRow* hessian, const BoxTile& tile);

  // Above every value of q on each box; NaN where nothing is known.
  TileRow upper(const BoxTile& tile) const;
  // Below every value of q on each box; NaN where nothing is known.
  TileRow lower(const BoxTile& tile) const;
  // Above |q(x) - q(y)| for all x, y of each box with |x - y|_2 <= distance; NaN where nothing is known.
  TileRow variation(const BoxTile& tile, double distance) const;
  // A corner or stationary point of the separable part of the form that makes it large (sign 1) or small
  // (sign -1): where to look for a violation. Not rigorous.
  Vector extreme_point(const BoxTile& tile, Eigen::Index lane, double sign) const;
  // The form's polynomial there. Not rigorous.
  double polynomial(const BoxTile& tile, Eigen::Index lane, const Vector& point) const;

  TileRow value;                  // of q at the centre, rounded
  std::vector<TileRow> gradient;  // [n]
  std::vector<TileRow> hessian;   // [n (n + 1) / 2], rows of the upper triangle
  std::vector<TileRow> cubic;     // [n, n (n + 1) / 2]: dx_d dx_e dx_g has as many places as orders
  TileRow remainder;              // what the polynomial leaves out, >= 0
  TileRow magnitude;              // sum of |terms| that went into the polynomial's coefficients
  double operations = 16;         // how many roundings a term can have gone through

 private:
  TileRow bound(const BoxTile& tile, double sign) const;
  TileRow cubic_size(const BoxTile& tile) const;  // above |C(dx)|, but for roundings
  // Above what the polynomial leaves out, with the roundings of terms of this size.
  TileRow error(const TileRow& size) const;
  // Calls back with d <= e <= g and the coefficient of dx_d dx_e dx_g.
  template <typename Visit>
  void for_cubes(const Visit& visit) const;
};

// How often to bisect a box of R^n until a form's upper bound may be negative, from the least value of its polynomial and
// its remainder: at least once, and 60 times at most.
std::int32_t useful_cuts(Eigen::Index n, double least_polynomial, double remainder);

// A function R^n -> R^m that can be enclosed by Taylor models over tiles of boxes, in exact arithmetic with
// every rounding covered: a network, a polynomial. Compositions are expanded by a forward and a backward
// sweep: the forward sweep gives second-order models of every quantity on the way; the backward one weighs
// the local second and third-order terms and remainders of every elementary operation with their influence on the
// scalar in question (its adjoint, to first order), so that no remainder passes through |W| after |W|.
class TaylorFunction {
 public:
  // What the sweeps leave in memory; one for each thread.
  class Workspace {
   public:
    virtual ~Workspace() = default;
  };
  virtual ~TaylorFunction() = default;

  virtual Eigen::Index input_dimension() const = 0;   // n
  virtual Eigen::Index output_dimension() const = 0;  // m
  // Above every number that its sweeps pass on for each 1 that they take in, and above its values, over |x|_inf <=
  // reach: what says whether underflow is covered (rounding.h). NaN or infinite where that cannot be said.
  virtual double growth(double reach) const = 0;
  virtual std::unique_ptr<Workspace> workspace() const = 0;  // memory that fits this function

  // Models of all outputs.
  virtual void models(const BoxTile& tile, Workspace& workspace, TileModels& y) const = 0;
  // After models(): adds sum_i adjoint_i(x) (y_i(x) - value_i - slope_i . dx) to q, adjoint [m, 1 + n] the value at the
  // centre and the slopes of affine functions.
  virtual void add_deviations(const BoxTile& tile, Workspace& workspace, const std::vector<TileRow>& adjoint,
                              TileForm& q) const = 0;

  // Models of the partial derivatives dy_i/dx_axis of all outputs i.
  virtual void partial_models(const BoxTile& tile, Workspace& workspace, Eigen::Index axis,
                              TileModels& partials) const = 0;

  // Models of all outputs and, one for each axis, of their partial derivatives.
  virtual void jacobian_models(const BoxTile& tile, Workspace& workspace, TileModels& y,
                               std::vector<TileModels>& partials) const;

  // Scalar functions only (m = 1). Models of the gradient [n]: looser than a form for each axis on large boxes, and several
  // times cheaper.
  virtual void gradient_models(const BoxTile& tile, Workspace& workspace, TileModels& gradient) const = 0;
  // Scalar functions only. Adds y(x) to q.
  virtual void add_value(const BoxTile& tile, Workspace& workspace, TileForm& q) const = 0;
  // Scalar functions only. Adds grad y(x) . d(x) to q, d given by its models [n] but for sum_i adjoint_i(x)
  // (d_i(x) - value_i - slope_i . dx), which the caller still has to add: adjoint [n, 1 + n] is returned, as
  // add_deviations takes it.
  virtual void add_derivative(const BoxTile& tile, Workspace& workspace, const TileModels& direction,
                              std::vector<TileRow>& adjoint, TileForm& q) const = 0;

  // Around the goal, for each of the T cubes |x|_inf <= half: [m, n] such that y(x) = A(x) x with A(x) in it; none unless
  // y(0) = 0 exactly.
  virtual std::vector<IntervalMatrix> goal_factors(const TileRow& half) const = 0;
  // Scalar functions only, [n, n] for each cube: grad y(x) = G(x) x with G(x) in it, for all x of the cube; none unless y(0) = 0
  // and grad y(0) = 0 exactly. Then also y(x) = x' S(x) x with 2 S(x) in it.
  virtual std::vector<IntervalMatrix> goal_gradient_factors(const TileRow& half) const = 0;
  // Whether y(0) = 0 exactly, in every output, for a reason that needs no arithmetic.
  virtual bool vanishes_at_goal() const = 0;
  // Scalar functions only: y(0) = 0 and y > 0 elsewhere for a reason that needs no boxes.
  virtual bool is_positive_by_construction() const { return false; }
};

// A function of x alone and its derivative along a vector field, with their memory: one for each thread.
class ScalarEnclosure {
 public:
  // `field` may be null: lie_derivative() throws Error then. Throws Error unless `function` maps R^n to R and
  // `field` maps R^n to R^n. Both must outlive this.
  ScalarEnclosure(const TaylorFunction& function, const TaylorFunction* field);

  const TileForm& value(const BoxTile& tile);           // y
  const TileForm& lie_derivative(const BoxTile& tile);  // grad y . field
  const TileModels& gradient(const BoxTile& tile);      // grad y
  // The partial derivative dy/dx_axis; tighter than gradient() on large boxes.
  const TileForm& partial_derivative(const BoxTile& tile, Eigen::Index axis);

 private:
  const TaylorFunction& function_;
  const TaylorFunction* field_;
  std::unique_ptr<TaylorFunction::Workspace> function_workspace_, field_workspace_;
  TileModels direction_, gradient_;
  std::vector<TileRow> adjoint_;
  TileForm form_;
};

}  // namespace s2nnds
