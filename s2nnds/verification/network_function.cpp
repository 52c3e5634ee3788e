// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/network_function.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/networks/dense_kernels.h"
#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/standard_floating_point.h"

namespace s2nnds {
namespace {

// Relative rounding error of a sum of `terms` products, rounded up.
double sum_rounding(Eigen::Index terms) { return 2.0 * (static_cast<double>(terms) + 4.0) * unit_roundoff; }

double* data(std::vector<TileRow>& rows) { return rows.front().data(); }

// y = W x for rows of tiles: x [in, columns, T], y [out, columns, T].
void multiply(const Points& weight, const std::vector<TileRow>& x, Eigen::Index columns,
              std::vector<TileRow>& y) {
  const std::ptrdiff_t stride = columns * tile_boxes;
  dense_kernels<double>().multiply(weight.rows(), stride, weight.cols(), weight.data(), weight.cols(), 1,
                                   x.front().data(), stride, y.front().data(), stride, false);
}
// x = W' y.
void multiply_transposed(const Points& weight, const std::vector<TileRow>& y, Eigen::Index columns,
                         std::vector<TileRow>& x) {
  const std::ptrdiff_t stride = columns * tile_boxes;
  dense_kernels<double>().multiply(weight.cols(), stride, weight.rows(), weight.data(), 1, weight.cols(),
                                   y.front().data(), stride, x.front().data(), stride, false);
}

// 2 p q' symmetrised: the Hessian of 2 (p . dx)(q . dx), times `weight`.
void add_product(const TileRow& weight, const TileRow* p, const TileRow* q, Eigen::Index n, TileForm& form) {
  std::size_t at = 0;
  for (Eigen::Index d = 0; d < n; ++d) {
    for (Eigen::Index e = d; e < n; ++e) form.hessian[at++] += weight * (p[d] * q[e] + q[d] * p[e]);
  }
}

// The adjoint value + 2 slope . dx.
void set_adjoint(const TileRow& value, const TileRow* slope, Eigen::Index n, TileRow* adjoint) {
  adjoint[0] = value;
  for (Eigen::Index d = 0; d < n; ++d) adjoint[1 + d] = 2.0 * slope[d];
}

}  // namespace

struct NetworkFunction::Memory final : TaylorFunction::Workspace {
  struct LayerMemory {
    std::vector<TileRow> z, z_remainder, expansion;
    std::vector<TileRow> magnitude_in;
  };
  std::vector<LayerMemory> layers;
  std::vector<TileRow> a, a_remainder;        // outputs of the layer last swept
  std::vector<TileRow> adjoint_a, adjoint_z;  // [width, 2, 1 + n]
  std::vector<TileRow> offset_error;          // [m] of the head's subtraction
  std::vector<TileRow> magnitude_out;         // [streams]
  std::vector<TileRow> factors;               // [2 n]
  Eigen::Index streams = 1;
};

NetworkFunction::NetworkFunction(const NetworkWeights& stack) : stack_(stack) {
  const StandardFloatingPoint mode;
  stack_.check();
  for (const Layer& layer : stack_.layers) {
    AffineMap map;
    map.weight = layer.weight;
    map.magnitude = layer.weight.cwiseAbs();
    map.bias = layer.bias.size() > 0 ? layer.bias : Vector::Zero(layer.weight.rows());
    const double rounding = sum_rounding(layer.weight.cols() + 1);
    map.adjoint_rounding = sum_rounding(layer.weight.rows());
    // The adjoint's rounding meets |W| |quadratic part|, term by term, of which the deviation of W a may have
    // cancelled: it is counted here, against the size of the model.
    map.row_error = (rounding + map.adjoint_rounding) * (map.magnitude.rowwise().sum() * (1.0 + rounding));
    map.bias_error = rounding * map.bias.cwiseAbs();
    map.remainder_growth = 1.0 + 2.0 * rounding;
    operations_ += 8.0 * static_cast<double>(layer.weight.rows());
    maps_.push_back(std::move(map));
  }
  operations_ += 8.0 * static_cast<double>(input_dimension());

  const Eigen::Index m = maps_.back().weight.rows(), n = input_dimension();
  offset_ = offset_error_ = Vector::Zero(m);
  if (stack_.head == Head::plain) return;
  BoxTile origin(n);
  const std::unique_ptr<Workspace> scratch = workspace();
  Memory& memory = static_cast<Memory&>(*scratch);
  forward(origin, nullptr, memory);
  for (Eigen::Index i = 0; i < m; ++i) {
    offset_(i) = memory.a[i * columns()](0);
    offset_error_(i) = memory.a_remainder[i](0) * slack;
  }
}

std::unique_ptr<TaylorFunction::Workspace> NetworkFunction::workspace() const {
  auto memory = std::make_unique<Memory>();
  const std::size_t streams = 1 + static_cast<std::size_t>(input_dimension()),
                    block = streams * static_cast<std::size_t>(columns());
  std::size_t widest = static_cast<std::size_t>(input_dimension());
  for (const AffineMap& map : maps_) {
    const std::size_t width = static_cast<std::size_t>(map.weight.rows());
    widest = std::max(widest, width);
    Memory::LayerMemory layer;
    layer.z.resize(width * block);
    layer.z_remainder.resize(width * streams);
    layer.magnitude_in.resize(streams);
    layer.expansion.resize(width * kept_rows);
    memory->layers.push_back(std::move(layer));
  }
  memory->a.resize(widest * block);
  memory->a_remainder.resize(widest * streams);
  memory->magnitude_out.resize(streams);
  memory->factors.resize(static_cast<std::size_t>(2 * input_dimension()));
  memory->adjoint_a.resize(widest * 2 * streams);
  memory->adjoint_z.resize(widest * 2 * streams);
  memory->offset_error.resize(static_cast<std::size_t>(maps_.back().weight.rows()));
  return memory;
}

LayerTile NetworkFunction::layer_tile(const BoxTile& tile, std::size_t k, Memory& memory) const {
  Memory::LayerMemory& layer = memory.layers[k];
  LayerTile result;
  result.width = maps_[k].weight.rows();
  result.dimension = input_dimension();
  result.streams = memory.streams;
  result.activation = stack_.layers[k].activation;
  result.half = tile.half.front().data();
  result.row_error = maps_[k].row_error.data();
  result.bias_error = maps_[k].bias_error.data();
  result.remainder_growth = maps_[k].remainder_growth;
  result.adjoint_rounding = maps_[k].adjoint_rounding;
  result.magnitude_in = layer.magnitude_in[0].data();
  result.magnitude_out = memory.magnitude_out[0].data();
  result.z = data(layer.z);
  result.z_remainder = data(layer.z_remainder);
  result.a = data(memory.a);
  result.a_remainder = data(memory.a_remainder);
  result.expansion = data(layer.expansion);
  return result;
}

void NetworkFunction::start(const BoxTile& tile, Eigen::Index streams, Memory& memory) const {
  memory.streams = streams;
  for (TileRow& size : memory.magnitude_out) size.setZero();
  for (Eigen::Index d = 0; d < input_dimension(); ++d) {  // x is its own model, without remainder
    TileRow* row = &memory.a[d * streams * columns()];
    std::fill(row, row + streams * columns(), TileRow());
    row[0] = tile.center[d];
    row[1 + d].setOnes();
    for (Eigen::Index s = 0; s < streams; ++s) memory.a_remainder[d * streams + s].setZero();
    memory.magnitude_out[0] = memory.magnitude_out[0].max((tile.center[d].abs() + tile.half[d]) * slack);
  }
}

void NetworkFunction::forward(const BoxTile& tile, const TileModels* direction, Memory& memory) const {
  const Eigen::Index n = input_dimension(), streams = direction != nullptr ? 2 : 1;
  start(tile, streams, memory);
  for (Eigen::Index d = 0; d < n && direction != nullptr; ++d) {
    std::copy_n(&direction->value(d), columns(), &memory.a[(2 * d + 1) * columns()]);
    memory.a_remainder[2 * d + 1] = direction->remainder[d];
    const TileRow size =
        direction->value(d).abs() + direction->spread(d, tile) + direction->deviation(d, tile);
    memory.magnitude_out[1] = memory.magnitude_out[1].max(size * slack);
  }
  sweep(tile, memory);
}

void NetworkFunction::forward_along_axes(const BoxTile& tile, Memory& memory) const {
  const Eigen::Index n = input_dimension(), streams = 1 + n;
  start(tile, streams, memory);
  for (Eigen::Index d = 0; d < n; ++d) {
    memory.a[(d * streams + 1 + d) * columns()].setOnes();
    memory.magnitude_out[1 + d].setOnes();
  }
  sweep(tile, memory);
}

void NetworkFunction::sweep(const BoxTile& tile, Memory& memory) const {
  const Eigen::Index streams = memory.streams, block = streams * columns();
  for (std::size_t k = 0; k < maps_.size(); ++k) {
    Memory::LayerMemory& layer = memory.layers[k];
    std::copy_n(memory.magnitude_out.begin(), streams, layer.magnitude_in.begin());
    const Eigen::Index width = maps_[k].weight.rows();
    multiply(maps_[k].weight, memory.a, block, layer.z);
    multiply(maps_[k].magnitude, memory.a_remainder, streams, layer.z_remainder);
    for (Eigen::Index i = 0; i < width; ++i) layer.z[i * block] += maps_[k].bias(i);
    taylor_kernels().activate(layer_tile(tile, k, memory));
  }
}

void NetworkFunction::backward(const BoxTile& tile, Memory& memory, std::vector<TileRow>* direction,
                               TileForm& q) const {
  const Eigen::Index affine = 1 + input_dimension();
  for (std::size_t k = maps_.size(); k-- > 0;) {
    const PullBackTile sweep = {.adjoint_a = data(memory.adjoint_a),
                                .adjoint_z = data(memory.adjoint_z),
                                .hessian = data(q.hessian),
                                .cubic = data(q.cubic),
                                .magnitude = q.magnitude.data(),
                                .remainder = q.remainder.data(),
                                .scratch = data(memory.factors)};
    taylor_kernels().pull_back(layer_tile(tile, k, memory), sweep);
    if (k > 0 || direction != nullptr) {
      multiply_transposed(maps_[k].weight, memory.adjoint_z, memory.streams * affine, memory.adjoint_a);
    }
  }
  q.operations += operations_;
  if (direction == nullptr) return;
  for (Eigen::Index d = 0; d < input_dimension(); ++d) {
    for (Eigen::Index c = 0; c < affine; ++c)
      (*direction)[d * affine + c] += memory.adjoint_a[(2 * d + 1) * affine + c];
  }
}

// N(x) - N(0) in the value stream; the error of the subtraction, N(0)'s included, goes to offset_error.
void NetworkFunction::subtract_offset(Memory& memory) const {
  const Eigen::Index block = memory.streams * columns();
  for (Eigen::Index i = 0; i < maps_.back().weight.rows(); ++i) {
    TileRow& value = memory.a[i * block];
    const double rounding = stack_.head == Head::plain ? 0.0 : 4.0 * unit_roundoff;
    memory.offset_error[i] = offset_error_(i) + rounding * (value.abs() + std::abs(offset_(i)));
    if (stack_.head != Head::plain) value -= offset_(i);
    memory.a_remainder[i * memory.streams] += memory.offset_error[i];
  }
}

// All adjoints of the outputs 0.
void NetworkFunction::clear_adjoint(Memory& memory) const {
  const Eigen::Index rows = maps_.back().weight.rows() * memory.streams * (1 + input_dimension());
  std::fill_n(memory.adjoint_a.begin(), rows, TileRow());
}

void NetworkFunction::models(const BoxTile& tile, Workspace& workspace, TileModels& y) const {
  check(stack_.head != Head::squared_norm, "network function: a squared norm has no models of its own");
  Memory& memory = static_cast<Memory&>(workspace);
  forward(tile, nullptr, memory);
  subtract_offset(memory);
  std::copy_n(memory.a.begin(), y.models.size(), y.models.begin());
  for (std::size_t i = 0; i < y.remainder.size(); ++i) y.remainder[i] = memory.a_remainder[i] * slack;
}

// What a constant direction makes of the second stream.
void NetworkFunction::partial_models(const BoxTile& tile, Workspace& workspace, Eigen::Index axis,
                                     TileModels& partials) const {
  check(stack_.head != Head::squared_norm, "network function: a squared norm has no models of its own");
  Memory& memory = static_cast<Memory&>(workspace);
  TileModels direction(input_dimension(), input_dimension());
  direction.value(axis).setOnes();
  forward(tile, &direction, memory);
  for (Eigen::Index i = 0; i < output_dimension(); ++i) {
    std::copy_n(&memory.a[(2 * i + 1) * columns()], columns(), &partials.value(i));
    partials.remainder[i] = memory.a_remainder[2 * i + 1] * slack;
  }
}

void NetworkFunction::jacobian_models(const BoxTile& tile, Workspace& workspace, TileModels& y,
                                      std::vector<TileModels>& partials) const {
  check(stack_.head != Head::squared_norm, "network function: a squared norm has no models of its own");
  Memory& memory = static_cast<Memory&>(workspace);
  forward_along_axes(tile, memory);
  subtract_offset(memory);
  for (Eigen::Index i = 0; i < output_dimension(); ++i) {
    for (Eigen::Index s = 0; s < memory.streams; ++s) {
      TileModels& to = s == 0 ? y : partials[static_cast<std::size_t>(s - 1)];
      const Eigen::Index at = i * memory.streams + s;
      std::copy_n(&memory.a[at * columns()], columns(), &to.value(i));
      to.remainder[i] = memory.a_remainder[at] * slack;
    }
  }
}

void NetworkFunction::gradient_models(const BoxTile& tile, Workspace& workspace, TileModels& gradient) const {
  Memory& memory = static_cast<Memory&>(workspace);
  forward_along_axes(tile, memory);
  subtract_offset(memory);
  for (Eigen::Index axis = 0; axis < input_dimension(); ++axis) {
    if (stack_.head == Head::squared_norm) {
      norm_gradient(tile, memory, axis, gradient);
    } else {
      std::copy_n(&memory.a[(1 + axis) * columns()], columns(), &gradient.value(axis));
      gradient.remainder[axis] = memory.a_remainder[1 + axis] * slack;
    }
  }
}

// 2 sum_i u_i du_i/dx_axis + 2 quadratic x_axis, from the models of u and du/dx_axis: what is beyond second order in
// their product, and the roundings, against the size of all terms, are in the remainder.
void NetworkFunction::norm_gradient(const BoxTile& tile, const Memory& memory, Eigen::Index axis,
                                    TileModels& gradient) const {
  const Eigen::Index n = input_dimension(), m = maps_.back().weight.rows(), streams = memory.streams;
  TileRow &value = gradient.value(axis), *slope = gradient.slope(axis), *hessian = gradient.hessian(axis);
  std::fill(&value, &value + columns(), TileRow());
  value = 2.0 * stack_.quadratic * tile.center[axis];
  slope[axis].setConstant(2.0 * stack_.quadratic);
  TileRow magnitude = 2.0 * stack_.quadratic * (tile.center[axis].abs() + tile.half[axis]), remainder;
  for (Eigen::Index i = 0; i < m; ++i) {
    const TileRow *u = &memory.a[i * streams * columns()], *p = u + (1 + axis) * columns();
    const TileRow &r = memory.a_remainder[i * streams], &p_r = memory.a_remainder[i * streams + 1 + axis];
    const TileRow spread = linear_size(u + 1, tile), p_spread = linear_size(p + 1, tile);
    const TileRow curve = quadratic_size(u + 1 + n, tile), p_curve = quadratic_size(p + 1 + n, tile);
    value += 2.0 * u[0] * p[0];
    std::size_t at = 0;
    for (Eigen::Index d = 0; d < n; ++d) {
      slope[d] += 2.0 * (u[0] * p[1 + d] + p[0] * u[1 + d]);
      for (Eigen::Index e = d; e < n; ++e, ++at) {
        hessian[at] +=
            2.0 * (u[0] * p[1 + n + at] + p[0] * u[1 + n + at] + u[1 + d] * p[1 + e] + u[1 + e] * p[1 + d]);
      }
    }
    remainder += 2.0 * (u[0].abs() * p_r + p[0].abs() * r + spread * (p_curve + p_r) +
                        (curve + r) * p_spread + (curve + r) * (p_curve + p_r));
    magnitude += 2.0 * (u[0].abs() + spread + curve) * (p[0].abs() + p_spread + p_curve);
  }
  gradient.remainder[axis] = (remainder + sum_rounding(m + 4) * magnitude) * slack;
}

void NetworkFunction::add_deviations(const BoxTile& tile, Workspace& workspace,
                                     const std::vector<TileRow>& adjoint, TileForm& q) const {
  Memory& memory = static_cast<Memory&>(workspace);
  const Eigen::Index affine = 1 + input_dimension();
  std::copy(adjoint.begin(), adjoint.end(), memory.adjoint_a.begin());
  for (Eigen::Index i = 0; i < output_dimension(); ++i) {
    const TileRow* slope = &adjoint[static_cast<std::size_t>(i * affine + 1)];
    q.remainder += (slope[-1].abs() + linear_size(slope, tile)) * memory.offset_error[i];
  }
  backward(tile, memory, nullptr, q);
}

void NetworkFunction::add_value(const BoxTile& tile, Workspace& workspace, TileForm& q) const {
  Memory& memory = static_cast<Memory&>(workspace);
  forward(tile, nullptr, memory);
  subtract_offset(memory);
  if (stack_.head == Head::squared_norm) return add_norm(tile, memory, q);
  q.add_line(memory.a[0], &memory.a[1], tile);
  q.remainder += memory.offset_error[0];
  clear_adjoint(memory);
  memory.adjoint_a[0].setOnes();
  backward(tile, memory, nullptr, q);
}

// |u|^2 + quadratic |x|^2, u = u0 + slope . dx + du: 2 (u0 + slope . dx) du is left to the backward sweep.
void NetworkFunction::add_norm(const BoxTile& tile, Memory& memory, TileForm& q) const {
  const Eigen::Index n = input_dimension();
  for (Eigen::Index i = 0; i < maps_.back().weight.rows(); ++i) {
    const TileRow* slope = &memory.a[i * columns() + 1];
    const TileRow u = memory.a[i * columns()], r = memory.a_remainder[i];
    const TileRow spread = linear_size(slope, tile), deviation = quadratic_size(slope + n, tile) + r;
    for (Eigen::Index d = 0; d < n; ++d) q.gradient[d] += 2.0 * u * slope[d];
    q.value += u.square();
    q.magnitude += (u.abs() + spread).square();
    add_product(TileRow(TileRow::Ones()), slope, slope, n, q);
    q.remainder += deviation.square() + 2.0 * (u.abs() + spread) * memory.offset_error[i];
    set_adjoint(2.0 * u, slope, n, &memory.adjoint_a[i * (1 + n)]);
  }
  std::size_t at = 0;
  for (Eigen::Index d = 0; d < n; ++d) {
    q.value += stack_.quadratic * tile.center[d].square();
    q.gradient[d] += 2.0 * stack_.quadratic * tile.center[d];
    q.hessian[at] += 2.0 * stack_.quadratic;
    q.magnitude += stack_.quadratic * (tile.center[d].abs() + tile.half[d]).square();
    at += static_cast<std::size_t>(n - d);
  }
  backward(tile, memory, nullptr, q);
}

void NetworkFunction::add_derivative(const BoxTile& tile, Workspace& workspace, const TileModels& direction,
                                     std::vector<TileRow>& adjoint, TileForm& q) const {
  Memory& memory = static_cast<Memory&>(workspace);
  for (TileRow& row : adjoint) row.setZero();
  forward(tile, &direction, memory);
  subtract_offset(memory);
  if (stack_.head == Head::squared_norm) return add_norm_rate(tile, direction, memory, adjoint, q);
  const TileRow* rate = &memory.a[columns()];
  q.add_line(rate[0], rate + 1, tile);
  clear_adjoint(memory);
  memory.adjoint_a[1 + input_dimension()].setOnes();
  backward(tile, memory, &adjoint, q);
}

// 2 u . du/dt + 2 quadratic x . direction.
void NetworkFunction::add_norm_rate(const BoxTile& tile, const TileModels& direction, Memory& memory,
                                    std::vector<TileRow>& adjoint, TileForm& q) const {
  const Eigen::Index n = input_dimension(), block = 2 * columns();
  const double weight = 2.0 * stack_.quadratic;
  for (Eigen::Index i = 0; i < maps_.back().weight.rows(); ++i) {
    const TileRow *slope = &memory.a[i * block + 1], *rate_slope = slope + columns();
    const TileRow u = memory.a[i * block], rate = memory.a[i * block + columns()];
    const TileRow r = memory.a_remainder[2 * i], rate_r = memory.a_remainder[2 * i + 1];
    const TileRow spread = linear_size(slope, tile), rate_spread = linear_size(rate_slope, tile);
    const TileRow deviation = quadratic_size(slope + n, tile) + r;
    const TileRow rate_deviation = quadratic_size(rate_slope + n, tile) + rate_r;
    for (Eigen::Index d = 0; d < n; ++d) q.gradient[d] += 2.0 * (u * rate_slope[d] + rate * slope[d]);
    q.value += 2.0 * u * rate;
    q.magnitude += 2.0 * (u.abs() + spread) * (rate.abs() + rate_spread);
    add_product(TileRow(TileRow::Constant(2.0)), slope, rate_slope, n, q);
    q.remainder += 2.0 * (deviation * rate_deviation + (rate.abs() + rate_spread) * memory.offset_error[i]);
    set_adjoint(2.0 * rate, rate_slope, n, &memory.adjoint_a[2 * i * (1 + n)]);
    set_adjoint(2.0 * u, slope, n, &memory.adjoint_a[(2 * i + 1) * (1 + n)]);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const TileRow &x = tile.center[i], &h = tile.half[i], &f = direction.value(i);
    const TileRow spread = direction.spread(i, tile);
    q.value += weight * x * f;
    q.magnitude += weight * (x.abs() + h) * (f.abs() + spread);
    q.gradient[i] += weight * f;
    std::size_t at = 0;
    for (Eigen::Index d = 0; d < n; ++d) {
      q.gradient[d] += weight * x * direction.slope(i)[d];
      for (Eigen::Index e = d; e < n; ++e, ++at) {
        if (d == i) q.hessian[at] += weight * direction.slope(i)[e];
        if (e == i) q.hessian[at] += weight * direction.slope(i)[d];
      }
    }
    q.remainder += 8.0 * unit_roundoff * weight * (x.abs() + h) * direction.deviation(i, tile);
    adjoint[i * (1 + n)] += weight * x;
    adjoint[i * (1 + n) + 1 + i] += weight;
  }
  backward(tile, memory, &adjoint, q);
}

std::vector<IntervalMatrix> NetworkFunction::jacobians(const TileRow& half) const {
  const Eigen::Index n = input_dimension(), m = maps_.back().weight.rows();
  BoxTile tile(n);
  for (TileRow& row : tile.half) row = half;
  const std::unique_ptr<Workspace> scratch = workspace();
  Memory& memory = static_cast<Memory&>(*scratch);
  forward_along_axes(tile, memory);
  std::vector<IntervalMatrix> result(tile_boxes, IntervalMatrix(m, n));
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index axis = 0; axis < n; ++axis) {
      const Eigen::Index at = i * memory.streams + 1 + axis;
      const TileRow* rate = &memory.a[at * columns()];
      const TileRow radius = (memory.a_remainder[at] + linear_size(rate + 1, tile) +
                              quadratic_size(rate + 1 + n, tile) + underflow) *
                             slack;
      for (Eigen::Index lane = 0; lane < tile_boxes; ++lane)
        result[static_cast<std::size_t>(lane)](i, axis) =
            Interval(rate[0](lane)) + radius(lane) * Interval(-1.0, 1.0);
    }
  }
  return result;
}

// The most that an activation's derivatives, up to the fifth, multiply by, with the roundings of these sums.
constexpr double activation_growth = 8.0;

double NetworkFunction::growth(double reach) const {
  double growth = std::max({1.0, reach, std::abs(stack_.quadratic)});
  for (const AffineMap& map : maps_) {
    // Rows in the forward sweep, columns in the backward one.
    growth *= activation_growth *
              std::max({1.0, map.magnitude.rowwise().sum().maxCoeff(),
                        map.magnitude.colwise().sum().maxCoeff(), map.bias.cwiseAbs().maxCoeff()});
  }
  return growth;
}

bool NetworkFunction::vanishes_at_goal() const {
  if (stack_.head != Head::plain) return true;
  return std::all_of(stack_.layers.begin(), stack_.layers.end(), [](const Layer& layer) {
    return (layer.bias.array() == 0.0).all() && layer.activation != Activation::softplus;
  });
}

// Along the ray from 0 to x: N(x) - N(0) = (integral of the Jacobian) x, and the integral lies in the convex
// hull.
std::vector<IntervalMatrix> NetworkFunction::goal_factors(const TileRow& half) const {
  if (stack_.head == Head::squared_norm || !vanishes_at_goal()) return {};
  return jacobians(half);
}

std::vector<IntervalMatrix> NetworkFunction::goal_gradient_factors(const TileRow& half) const {
  if (stack_.head != Head::squared_norm) return {};
  // grad |N(x) - N(0)|^2 = 2 J(x)' P(x) x, both J and P in the Jacobian over the cube.
  std::vector<IntervalMatrix> factors = jacobians(half);
  for (IntervalMatrix& factor : factors) {
    factor = factor.transposed() * factor;
    for (Eigen::Index d = 0; d < factor.rows(); ++d) factor(d, d) += stack_.quadratic;
    factor = 2.0 * factor;
  }
  return factors;
}

bool NetworkFunction::is_positive_by_construction() const {
  return stack_.head == Head::squared_norm && stack_.quadratic > 0.0;
}

}  // namespace s2nnds
