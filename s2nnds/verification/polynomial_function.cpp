// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/polynomial_function.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/verification/rounding.h"

namespace s2nnds {
namespace {

constexpr int expansion_orders = 5;  // 0, ..., 4

// How often the monomial dx_a dx_b dx_c ... of these axes occurs in the Taylor sum, over the factorial of
// their number: 1 / (product of the factorials of the axes' multiplicities).
double taylor_weight(const std::vector<Eigen::Index>& axes) {
  double weight = 1.0;
  for (std::size_t i = 0, run = 1; i < axes.size(); ++i, ++run) {
    if (i > 0 && axes[i] != axes[i - 1]) run = 1;
    weight /= static_cast<double>(run);
  }
  return weight;
}

}  // namespace

struct PolynomialFunction::Memory final : TaylorFunction::Workspace {
  std::vector<TileRow> powers, sizes;  // [n, degree + 1] powers of the centre and of |centre| + half
  std::vector<TileForm> outputs;       // [m] of the last call of models()
  TileForm gradient = TileForm(0);
};

PolynomialFunction::PolynomialFunction(const std::vector<Polynomial>& outputs) {
  check(!outputs.empty(), "polynomial function: found no polynomials, expected at least one");
  dimension_ = outputs.front().dimension();
  for (const Polynomial& polynomial : outputs) {
    check(polynomial.dimension() == dimension_, "polynomial function: found {} variables, expected {}",
          polynomial.dimension(), dimension_);
    degree_ = std::max(degree_, polynomial.degree());
    outputs_.push_back(partials_of(polynomial, expansion_orders));
  }
  for (const Polynomial& polynomial : outputs) {
    for (Eigen::Index d = 0; d < dimension_; ++d)
      gradients_.push_back(partials_of(polynomial.derivative(d), expansion_orders));
  }
}

PolynomialFunction::Partials PolynomialFunction::partials_of(const Polynomial& polynomial, int orders) {
  Partials partials = {{{{}, polynomial.coefficients(), polynomial.exponents()}}};
  for (int order = 1; order < orders; ++order) {
    std::vector<Partial> next;
    for (const Partial& partial : partials.back()) {
      for (Eigen::Index d = partial.axes.empty() ? 0 : partial.axes.back(); d < polynomial.dimension(); ++d) {
        Partial derived = partial;
        derived.axes.push_back(d);
        derived.coefficients.array() *= partial.exponents.col(d).cast<double>().array();
        derived.exponents.col(d) = (partial.exponents.col(d).array() - 1).max(0);
        next.push_back(std::move(derived));
      }
    }
    partials.push_back(std::move(next));
  }
  return partials;
}

std::unique_ptr<TaylorFunction::Workspace> PolynomialFunction::workspace() const {
  auto memory = std::make_unique<Memory>();
  memory->powers.resize(static_cast<std::size_t>(dimension_ * (degree_ + 1)));
  memory->sizes = memory->powers;
  memory->outputs.assign(outputs_.size(), TileForm(dimension_));
  memory->gradient = TileForm(dimension_);
  return memory;
}

void PolynomialFunction::expand(const Partials& partials, const BoxTile& tile, Memory& memory,
                                TileForm& form) const {
  const Eigen::Index columns = degree_ + 1;
  for (Eigen::Index d = 0; d < dimension_; ++d) {
    memory.powers[d * columns].setOnes();
    memory.sizes[d * columns].setOnes();
    for (Eigen::Index k = 1; k < columns; ++k) {
      memory.powers[d * columns + k] = memory.powers[d * columns + k - 1] * tile.center[d];
      memory.sizes[d * columns + k] =
          memory.sizes[d * columns + k - 1] * (tile.center[d].abs() + tile.half[d]);
    }
  }
  // Value at the centre and the sum of |terms| over the box.
  const auto evaluate = [&](const Partial& partial, TileRow& value, TileRow& size) {
    value.setZero();
    size.setZero();
    for (Eigen::Index k = 0; k < partial.coefficients.size(); ++k) {
      TileRow term = TileRow::Base::Constant(partial.coefficients(k)), bound = term.abs();
      for (Eigen::Index d = 0; d < dimension_; ++d) {
        term *= memory.powers[d * columns + partial.exponents(k, d)];
        bound *= memory.sizes[d * columns + partial.exponents(k, d)];
      }
      value += term;
      size += bound;
    }
  };
  form.clear();
  TileRow value, size;
  for (std::size_t order = 0; order < partials.size(); ++order) {
    for (const Partial& partial : partials[order]) {
      evaluate(partial, value, size);
      const double terms =
          static_cast<double>(partial.coefficients.size() + (degree_ + 2) * (dimension_ + 1) + 16);
      const TileRow rounding = 4.0 * unit_roundoff * terms * size;
      TileRow weight = TileRow::Base::Constant(taylor_weight(partial.axes) * polynomial_slack);
      for (Eigen::Index axis : partial.axes) weight *= tile.half[axis];
      if (order == 0) form.value = value;
      if (order == 1) form.gradient[partial.axes[0]] = value;
      if (order == 2) form.hessian[triangle_row(partial.axes[0], partial.axes[1], dimension_)] = value;
      // The third derivatives at the centre and the fourth ones anywhere (Lagrange), or roundings.
      if (order < 3) {
        form.remainder += weight * rounding;
      } else if (order == 3) {
        form.remainder += weight * (value.abs() + rounding);
      } else {
        form.remainder += weight * size * polynomial_slack;
      }
    }
  }
  form.remainder *= polynomial_slack;
}

namespace {

void put(const TileForm& form, Eigen::Index i, TileModels& y) {
  y.value(i) = form.value;
  y.remainder[i] = form.remainder;
  std::copy(form.gradient.begin(), form.gradient.end(), y.slope(i));
  std::copy(form.hessian.begin(), form.hessian.end(), y.hessian(i));
}

}  // namespace

void PolynomialFunction::models(const BoxTile& tile, Workspace& workspace, TileModels& y) const {
  Memory& memory = static_cast<Memory&>(workspace);
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    expand(outputs_[i], tile, memory, memory.outputs[i]);
    put(memory.outputs[i], static_cast<Eigen::Index>(i), y);
  }
}

void PolynomialFunction::partial_models(const BoxTile& tile, Workspace& workspace, Eigen::Index axis,
                                        TileModels& partials) const {
  Memory& memory = static_cast<Memory&>(workspace);
  for (Eigen::Index i = 0; i < output_dimension(); ++i) {
    expand(gradients_[static_cast<std::size_t>(i * dimension_ + axis)], tile, memory, memory.gradient);
    put(memory.gradient, i, partials);
  }
}

void PolynomialFunction::gradient_models(const BoxTile& tile, Workspace& workspace,
                                         TileModels& gradient) const {
  Memory& memory = static_cast<Memory&>(workspace);
  for (Eigen::Index axis = 0; axis < dimension_; ++axis) {
    expand(gradients_[static_cast<std::size_t>(axis)], tile, memory, memory.gradient);
    put(memory.gradient, axis, gradient);
  }
}

void PolynomialFunction::add_deviations(const BoxTile& tile, Workspace& workspace,
                                        const std::vector<TileRow>& adjoint, TileForm& q) const {
  Memory& memory = static_cast<Memory&>(workspace);
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const TileForm& form = memory.outputs[i];
    const TileRow* weight = &adjoint[i * static_cast<std::size_t>(1 + dimension_)];
    q.add_curvature(weight[0], form.hessian, tile);
    q.add_cubic(weight + 1, form.hessian.data(), tile);
    q.remainder += (weight[0].abs() + linear_size(weight + 1, tile)) * form.remainder * polynomial_slack;
  }
  q.operations += 4.0 * static_cast<double>(outputs_.size());
}

void PolynomialFunction::add_value(const BoxTile& tile, Workspace& workspace, TileForm& q) const {
  Memory& memory = static_cast<Memory&>(workspace);
  TileForm& form = memory.gradient;
  expand(outputs_.front(), tile, memory, form);
  q.remainder += form.remainder;
  q.add_line(form.value, form.gradient.data(), tile);
  q.add_curvature(TileRow::Ones(), form.hessian, tile);
}

// sum_i g_i d_i with g_i = dy/dx_i to second order and d_i = model_i + deviation_i; (g_i(c) + its slope . dx) deviation_i is
// left to the caller.
void PolynomialFunction::add_derivative(const BoxTile& tile, Workspace& workspace,
                                        const TileModels& direction, std::vector<TileRow>& adjoint,
                                        TileForm& q) const {
  Memory& memory = static_cast<Memory&>(workspace);
  for (Eigen::Index i = 0; i < dimension_; ++i) {
    TileForm& g = memory.gradient;
    expand(gradients_[static_cast<std::size_t>(i)], tile, memory, g);
    const TileRow &value = direction.value(i), r = direction.deviation(i, tile);
    const TileRow* slope = direction.slope(i);
    const TileRow spread = direction.spread(i, tile);
    TileRow linear, quadratic;
    q.value += g.value * value;
    for (Eigen::Index d = 0; d < dimension_; ++d) {
      q.gradient[d] += value * g.gradient[d] + g.value * slope[d];
      linear += g.gradient[d].abs() * tile.half[d];
      for (Eigen::Index e = d; e < dimension_; ++e) {
        const Eigen::Index at = triangle_row(d, e, dimension_);
        q.hessian[at] += value * g.hessian[at] + g.gradient[d] * slope[e] + g.gradient[e] * slope[d];
        quadratic += (d == e ? 0.5 : 1.0) * g.hessian[at].abs() * tile.half[d] * tile.half[e];
      }
    }
    // Where the diagonal's 1/2 is missing the magnitude is only larger.
    q.magnitude += (g.value.abs() + 2.0 * linear + 2.0 * quadratic) * (value.abs() + 2.0 * spread);
    q.add_cubic(slope, g.hessian.data(), tile);
    q.remainder += (quadratic * r + g.remainder * (value.abs() + spread + r)) * polynomial_slack;
    adjoint[i * (1 + dimension_)] = g.value;
    std::copy(g.gradient.begin(), g.gradient.end(), &adjoint[i * (1 + dimension_) + 1]);
  }
  q.operations += 8.0 * static_cast<double>(dimension_);
}

Interval PolynomialFunction::on_cube(const Partial& partial, double half) {
  Interval sum(0.0);
  const Interval coefficient_error(1.0 - 16.0 * unit_roundoff, 1.0 + 16.0 * unit_roundoff);
  for (Eigen::Index k = 0; k < partial.coefficients.size(); ++k) {
    Interval term = Interval(partial.coefficients(k)) * coefficient_error;
    for (Eigen::Index d = 0; d < partial.exponents.cols(); ++d) {
      if (partial.exponents(k, d) > 0) term *= power(Interval(-half, half), partial.exponents(k, d));
    }
    sum += term;
  }
  return sum;
}

// Every derivative up to the fourth brings down at most `degree_` once more; inner sums over the axes are finite.
double PolynomialFunction::growth(double reach) const {
  const double degree = std::max<double>(1.0, degree_), side = std::max(1.0, reach);
  double growth = side;
  for (const Partials& partials : outputs_) {
    const Partial& function = partials.front().front();
    const double size = function.coefficients.cwiseAbs().sum();
    growth = std::max(growth, size * std::pow(side, degree) * std::pow(degree, expansion_orders));
  }
  return growth;
}

bool PolynomialFunction::vanishes_at_goal() const {
  return std::all_of(outputs_.begin(), outputs_.end(),
                     [](const Partials& partials) { return vanishes_at_zero(partials.front().front()); });
}

// Exactly: no monomial but the constant one has a value at 0.
bool PolynomialFunction::vanishes_at_zero(const Partial& partial) {
  for (Eigen::Index k = 0; k < partial.coefficients.size(); ++k) {
    if (partial.coefficients(k) != 0.0 && (partial.exponents.row(k).array() == 0).all()) return false;
  }
  return true;
}

// Along the ray from 0 to x: p(x) = (integral of grad p) . x, which lies in the hull of grad p over the cube.
std::vector<IntervalMatrix> PolynomialFunction::goal_factors(const TileRow& half) const {
  if (!vanishes_at_goal()) return {};
  std::vector<IntervalMatrix> factors(tile_boxes, IntervalMatrix(output_dimension(), dimension_));
  for (std::size_t lane = 0; lane < factors.size(); ++lane) {
    for (Eigen::Index i = 0; i < output_dimension(); ++i) {
      for (const Partial& partial : outputs_[static_cast<std::size_t>(i)][1])
        factors[lane](i, partial.axes[0]) = on_cube(partial, half(static_cast<Eigen::Index>(lane)));
    }
  }
  return factors;
}

std::vector<IntervalMatrix> PolynomialFunction::goal_gradient_factors(const TileRow& half) const {
  const Partials& partials = outputs_.front();
  for (int order : {0, 1}) {
    for (const Partial& partial : partials[static_cast<std::size_t>(order)]) {
      if (!vanishes_at_zero(partial)) return {};
    }
  }
  std::vector<IntervalMatrix> factors(tile_boxes, IntervalMatrix(dimension_, dimension_));
  for (std::size_t lane = 0; lane < factors.size(); ++lane) {
    for (const Partial& partial : partials[2]) {
      const Interval entry = on_cube(partial, half(static_cast<Eigen::Index>(lane)));
      factors[lane](partial.axes[0], partial.axes[1]) = entry;
      factors[lane](partial.axes[1], partial.axes[0]) = entry;
    }
  }
  return factors;
}

}  // namespace s2nnds
