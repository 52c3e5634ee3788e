// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/taylor_model.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/interval.h"
#include "s2nnds/verification/rounding.h"

namespace s2nnds {
namespace {

// The maximum of g t + h t^2 / 2 over |t| <= w (rounded, to be inflated by the caller).
double parabola_maximum(double g, double h, double w) {
  const double slope = std::abs(g);
  if (h < 0.0 && slope < -h * w) return slope * slope / (-2.0 * h);
  return slope * w + 0.5 * h * w * w;
}

}  // namespace

void BoxTile::assign(const Points& lower, const Points& upper, Eigen::Index first, Eigen::Index count) {
  check(count > 0 && count <= tile_boxes && lower.cols() == dimension() && upper.cols() == dimension(),
        "box tile: found {} boxes of dimension {}, expected 1 to {} of dimension {}", count, lower.cols(),
        tile_boxes, dimension());
  for (Eigen::Index lane = 0; lane < tile_boxes; ++lane) {
    const Eigen::Index row = first + std::min(lane, count - 1);
    for (Eigen::Index d = 0; d < dimension(); ++d) {
      const double low = lower(row, d), high = upper(row, d),
                   middle = low == high ? low : 0.5 * low + 0.5 * high;
      center[d](lane) = middle;
      // A difference that rounds to zero is exact, so that a point stays a point.
      const double below = middle - low, above = high - middle;
      half[d](lane) = low == high ? 0.0 : next_up(std::max(below, above));
      if (!(low <= high)) center[d](lane) = std::nan("");
    }
  }
}

TileRow linear_size(const TileRow* slope, const BoxTile& tile) {
  TileRow sum;
  for (Eigen::Index d = 0; d < tile.dimension(); ++d) sum += slope[d].abs() * tile.half[d];
  return sum * slack;
}

TileRow quadratic_size(const TileRow* hessian, const BoxTile& tile) {
  TileRow sum;
  for (Eigen::Index d = 0; d < tile.dimension(); ++d) {
    sum += 0.5 * (hessian++)->abs() * tile.half[d].square();
    for (Eigen::Index e = d + 1; e < tile.dimension(); ++e)
      sum += (hessian++)->abs() * tile.half[d] * tile.half[e];
  }
  return sum * slack;
}

TileRow TileModels::spread(Eigen::Index i, const BoxTile& tile) const { return linear_size(slope(i), tile); }
TileRow TileModels::deviation(Eigen::Index i, const BoxTile& tile) const {
  return (quadratic_size(hessian(i), tile) + remainder[i]) * slack;
}

void TileForm::clear() {
  value.setZero();
  remainder.setZero();
  magnitude.setZero();
  for (TileRow& row : gradient) row.setZero();
  for (TileRow& row : hessian) row.setZero();
  for (TileRow& row : cubic) row.setZero();
  operations = 16;
}

TileForm TileForm::negative() const {
  TileForm result = *this;
  result.value = -value;
  for (std::vector<TileRow>* rows : {&result.gradient, &result.hessian, &result.cubic}) {
    for (TileRow& row : *rows) row = -row;
  }
  return result;
}

void TileForm::take(const TileForm& other, Eigen::Index lane, Eigen::Index to) {
  value(to) = other.value(lane);
  for (std::size_t d = 0; d < gradient.size(); ++d) gradient[d](to) = other.gradient[d](lane);
  for (std::size_t at = 0; at < hessian.size(); ++at) hessian[at](to) = other.hessian[at](lane);
  for (std::size_t at = 0; at < cubic.size(); ++at) cubic[at](to) = other.cubic[at](lane);
  remainder(to) = other.remainder(lane);
  magnitude(to) = other.magnitude(lane);
  operations = std::max(operations, other.operations);
}

void TileForm::add_line(const TileRow& line_value, const TileRow* slope, const BoxTile& tile) {
  value += line_value;
  magnitude += line_value.abs();
  for (std::size_t d = 0; d < gradient.size(); ++d) {
    gradient[d] += slope[d];
    magnitude += slope[d].abs() * tile.half[d];
  }
}

void TileForm::add_curvature(const TileRow& weight, const std::vector<TileRow>& rows, const BoxTile& tile) {
  std::size_t at = 0;
  for (std::size_t d = 0; d < gradient.size(); ++d) {
    for (std::size_t e = d; e < gradient.size(); ++e, ++at) {
      const TileRow term = weight * rows[at];
      hessian[at] += term;
      magnitude += term.abs() * tile.half[d] * tile.half[e];
    }
  }
}

void TileForm::add_cubic(const TileRow* slope, const TileRow* hessian_rows, const BoxTile& tile) {
  TileRow* row = cubic.data();
  for (std::size_t d = 0; d < gradient.size(); ++d) {
    const TileRow* entry = hessian_rows;
    for (std::size_t e = 0; e < gradient.size(); ++e) {
      for (std::size_t g = e; g < gradient.size(); ++g) *row++ += (e == g ? 0.5 : 1.0) * slope[d] * *entry++;
    }
  }
  magnitude += linear_size(slope, tile) * quadratic_size(hessian_rows, tile);
}

// Monomials that differ in order alone are one.
template <typename Visit>
void TileForm::for_cubes(const Visit& visit) const {
  const auto n = static_cast<Eigen::Index>(gradient.size());
  const auto at = [&](Eigen::Index d, Eigen::Index e, Eigen::Index g) -> const TileRow& {
    return cubic[static_cast<std::size_t>(d * triangle(n) + triangle_row(e, g, n))];
  };
  for (Eigen::Index d = 0; d < n; ++d) {
    for (Eigen::Index e = d; e < n; ++e) {
      for (Eigen::Index g = e; g < n; ++g) {
        TileRow sum = at(d, e, g);
        if (d != e) sum += at(e, d, g);
        if (e != g) sum += at(g, d, e);
        visit(d, e, g, sum);
      }
    }
  }
}

TileRow TileForm::upper(const BoxTile& tile) const { return bound(tile, 1.0); }
TileRow TileForm::lower(const BoxTile& tile) const { return -bound(tile, -1.0); }

TileRow TileForm::cubic_size(const BoxTile& tile) const {
  TileRow sum;
  for_cubes([&](Eigen::Index d, Eigen::Index e, Eigen::Index g, const TileRow& coefficient) {
    sum += coefficient.abs() * tile.half[d] * tile.half[e] * tile.half[g];
  });
  return sum * slack;
}

TileRow TileForm::error(const TileRow& size) const {
  const double roundings = 4.0 * unit_roundoff * operations;
  return remainder * (1.0 + roundings) + roundings * (magnitude + size) * (1.0 + roundings) + underflow;
}

TileRow TileForm::bound(const BoxTile& tile, double sign) const {
  const Eigen::Index n = tile.dimension();
  const TileRow cubes = cubic_size(tile);
  TileRow polynomials = cubes, sizes = value.abs() + cubes;
  for (Eigen::Index lane = 0; lane < tile_boxes; ++lane) {
    double &polynomial = polynomials(lane), &size = sizes(lane);
    std::size_t at = 0;
    for (Eigen::Index d = 0; d < n; ++d) {
      const double w = tile.half[d](lane), g = gradient[d](lane), h = hessian[at++](lane);
      polynomial += parabola_maximum(g, sign * h, w);
      size += std::abs(g) * w + std::abs(h) * w * w;
      for (Eigen::Index e = d + 1; e < n; ++e) {
        const double mixed = std::abs(hessian[at++](lane)) * w * tile.half[e](lane);
        polynomial += mixed;
        size += mixed;
      }
    }
  }
  return sign * value + (polynomials + error(sizes) * slack);
}

// The polynomial's gradient anywhere on the box, times the distance; what it leaves out may have both signs.
TileRow TileForm::variation(const BoxTile& tile, double distance) const {
  const Eigen::Index n = tile.dimension();
  TileRow slopes, size = value.abs();
  std::vector<TileRow> cubic_slope(gradient.size());
  for_cubes([&](Eigen::Index d, Eigen::Index e, Eigen::Index g, const TileRow& coefficient) {
    const TileRow c = coefficient.abs();
    size += c * tile.half[d] * tile.half[e] * tile.half[g];
    cubic_slope[d] += c * tile.half[e] * tile.half[g];
    cubic_slope[e] += c * tile.half[d] * tile.half[g];
    cubic_slope[g] += c * tile.half[d] * tile.half[e];
  });
  for (Eigen::Index d = 0; d < n; ++d) {
    TileRow slope = gradient[d].abs() + cubic_slope[d];
    for (Eigen::Index e = 0; e < n; ++e) {
      const TileRow& h = hessian[triangle_row(std::min(d, e), std::max(d, e), n)];
      slope += h.abs() * tile.half[e];
      size += h.abs() * tile.half[d] * tile.half[e];
    }
    size += gradient[d].abs() * tile.half[d];
    slopes += slope.square();
  }
  return (distance * slopes.sqrt() + 2.0 * error(size)) * slack;
}

Vector TileForm::extreme_point(const BoxTile& tile, Eigen::Index lane, double sign) const {
  const Eigen::Index n = tile.dimension();
  Vector point(n);
  std::size_t at = 0;
  for (Eigen::Index d = 0; d < n; ++d) {
    const double w = tile.half[d](lane), g = sign * gradient[d](lane), h = sign * hessian[at](lane);
    const double corner = g >= 0.0 ? w : -w;
    point(d) = tile.center[d](lane) + (h < 0.0 && std::abs(g) < -h * w ? -g / h : corner);
    at += static_cast<std::size_t>(n - d);
  }
  return point;
}

double TileForm::polynomial(const BoxTile& tile, Eigen::Index lane, const Vector& point) const {
  double sum = value(lane);
  for_cubes([&](Eigen::Index d, Eigen::Index e, Eigen::Index g, const TileRow& coefficient) {
    double cube = coefficient(lane);
    for (const Eigen::Index axis : {d, e, g}) cube *= point(axis) - tile.center[axis](lane);
    sum += cube;
  });
  std::size_t at = 0;
  for (Eigen::Index d = 0; d < point.size(); ++d) {
    const double x = point(d) - tile.center[d](lane);
    sum += gradient[d](lane) * x + 0.5 * hessian[at++](lane) * x * x;
    for (Eigen::Index e = d + 1; e < point.size(); ++e) {
      sum += hessian[at++](lane) * x * (point(e) - tile.center[e](lane));
    }
  }
  return sum;
}

// A part of the box is hopeless while its remainder alone exceeds what the polynomial offers at best. A cut multiplies a
// remainder of fourth order by shrink or so; parts that turn out provable earlier cost little.
std::int32_t useful_cuts(Eigen::Index n, double least_polynomial, double remainder) {
  constexpr std::int32_t most = 60;
  const double dimension = static_cast<double>(n), shrink = 0.7 * std::pow((dimension - 0.5) / dimension, 4);
  std::int32_t cuts = 1;
  for (double left = shrink * remainder; cuts < most && least_polynomial < 0.0 && left > -least_polynomial;
       left *= shrink) {
    ++cuts;
  }
  return cuts;
}

void TaylorFunction::jacobian_models(const BoxTile& tile, Workspace& workspace, TileModels& y,
                                     std::vector<TileModels>& partials) const {
  models(tile, workspace, y);
  for (std::size_t axis = 0; axis < partials.size(); ++axis)
    partial_models(tile, workspace, static_cast<Eigen::Index>(axis), partials[axis]);
}

ScalarEnclosure::ScalarEnclosure(const TaylorFunction& function, const TaylorFunction* field)
    : function_(function),
      field_(field),
      function_workspace_(function.workspace()),
      field_workspace_(field != nullptr ? field->workspace() : nullptr),
      direction_(function.input_dimension(), function.input_dimension()),
      gradient_(direction_),
      adjoint_(function.input_dimension() * (1 + function.input_dimension())),
      form_(function.input_dimension()) {
  const Eigen::Index n = function.input_dimension();
  check(function.output_dimension() == 1, "enclosure: found a function with {} outputs, expected 1",
        function.output_dimension());
  check(field == nullptr || (field->input_dimension() == n && field->output_dimension() == n),
        "enclosure: the field's dimension differs from the function's, {}", n);
}

const TileForm& ScalarEnclosure::value(const BoxTile& tile) {
  form_.clear();
  function_.add_value(tile, *function_workspace_, form_);
  return form_;
}

const TileForm& ScalarEnclosure::lie_derivative(const BoxTile& tile) {
  check(field_ != nullptr, "enclosure: found no vector field for a derivative");
  form_.clear();
  field_->models(tile, *field_workspace_, direction_);
  function_.add_derivative(tile, *function_workspace_, direction_, adjoint_, form_);
  field_->add_deviations(tile, *field_workspace_, adjoint_, form_);
  return form_;
}

const TileModels& ScalarEnclosure::gradient(const BoxTile& tile) {
  function_.gradient_models(tile, *function_workspace_, gradient_);
  return gradient_;
}

const TileForm& ScalarEnclosure::partial_derivative(const BoxTile& tile, Eigen::Index axis) {
  form_.clear();
  for (TileRow& row : direction_.models) row.setZero();
  for (TileRow& row : direction_.remainder) row.setZero();
  direction_.value(axis).setOnes();
  function_.add_derivative(tile, *function_workspace_, direction_, adjoint_, form_);
  return form_;
}

}  // namespace s2nnds
