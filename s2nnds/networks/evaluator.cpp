// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/evaluator.h"

#include <algorithm>

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"

namespace s2nnds {
namespace {

// Of a reverse sweep, as in FusedNetwork.
constexpr Eigen::Index kPartsPerThread = 4, kLeastParallelWork = 500000;

template <typename T>
FusedNetwork<T> pack(const NetworkWeights& stack) {
  stack.check();
  std::vector<LayerShape> shapes;
  std::vector<T> parameters;
  for (const Layer& layer : stack.layers) {
    shapes.push_back({layer.weight.cols(), layer.weight.rows(), layer.bias.size() > 0, layer.activation});
    parameters.insert(parameters.end(), layer.weight.data(), layer.weight.data() + layer.weight.size());
    parameters.insert(parameters.end(), layer.bias.data(), layer.bias.data() + layer.bias.size());
  }
  FusedNetwork<T> network(shapes);
  network.load(parameters.data());
  return network;
}

// x itself, or a copy in single precision.
template <typename T, typename Matrix>
decltype(auto) in_precision(const Matrix& x) {
  if constexpr (std::is_same_v<T, double>) {
    return (x);
  } else {
    return Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>(x.template cast<T>());
  }
}

}  // namespace

template <typename T>
BasicEvaluator<T>::BasicEvaluator(const NetworkWeights& stack)
    : network_(pack<T>(stack)), head_(stack.head), quadratic_(stack.quadratic) {
  at_origin_.setZero(1, network_.outputs());
  if (head_ != Head::plain) {
    const std::vector<T> zero(static_cast<std::size_t>(network_.inputs()), T(0));
    network_.forward(1, zero.data(), nullptr, at_origin_.data(), nullptr);
  }
}

template <typename T>
template <typename Rows>
void BasicEvaluator<T>::finish(const Rows& x, Matrix& raw) const {
  raw.rowwise() -= at_origin_.row(0);
  if (head_ == Head::diffeomorphism) raw += x;
}

template <typename T>
Points BasicEvaluator<T>::value(const Points& x) const {
  return value(Eigen::Map<const Points>(x.data(), x.rows(), x.cols()));
}

template <typename T>
Points BasicEvaluator<T>::value(const Eigen::Map<const Points>& x) const {
  check(x.cols() == input_dimension(), "network: found points of dimension {}, expected {}", x.cols(),
        input_dimension());
  const auto& at = in_precision<T>(x);
  Matrix raw(x.rows(), network_.outputs());
  network_.forward(x.rows(), at.data(), nullptr, raw.data(), nullptr);
  finish(at, raw);
  if (!is_sum_of_squares(head_)) return raw.template cast<double>();
  return raw.rowwise().squaredNorm().template cast<double>() + quadratic_ * x.rowwise().squaredNorm();
}

template <typename T>
void BasicEvaluator<T>::value_and_derivative(const Points& x, const Points& direction, Points& value,
                                             Points& derivative) const {
  check(
      x.cols() == input_dimension() && direction.cols() == input_dimension() && direction.rows() == x.rows(),
      "network: found points [{}, {}] and directions [{}, {}], expected both [N, {}]", x.rows(), x.cols(),
      direction.rows(), direction.cols(), input_dimension());
  const auto& at = in_precision<T>(x);
  const auto& along = in_precision<T>(direction);
  Matrix raw(x.rows(), network_.outputs()), tangent(x.rows(), network_.outputs());
  network_.forward(x.rows(), at.data(), along.data(), raw.data(), tangent.data());
  finish(at, raw);
  if (!is_sum_of_squares(head_)) {
    value = raw.template cast<double>();
    derivative = tangent.template cast<double>();
    return;
  }
  if (head_ == Head::diffeomorphism) tangent += along;
  value = raw.rowwise().squaredNorm().template cast<double>() + quadratic_ * x.rowwise().squaredNorm();
  derivative = 2.0 * (raw.cwiseProduct(tangent).rowwise().sum().template cast<double>() +
                      quadratic_ * x.cwiseProduct(direction).rowwise().sum());
}

template <typename T>
void BasicEvaluator<T>::value_and_gradient(const Points& x, Vector& value, Points& gradient) const {
  check(x.cols() == input_dimension() && output_dimension() == 1,
        "network: found points of dimension {} and {} outputs, expected {} and 1", x.cols(),
        output_dimension(), input_dimension());
  constexpr Eigen::Index tile_rows = FusedNetwork<T>::tile_rows;
  const Eigen::Index n = x.cols(), m = network_.outputs(), tiles = (x.rows() + tile_rows - 1) / tile_rows;
  value.resize(x.rows());
  gradient.resize(x.rows(), n);
  const auto run = [&](Eigen::Index begin, Eigen::Index end) {
    FusedTile<T> tile(network_);
    for (Eigen::Index t = begin; t < end; ++t) {
      const Eigen::Index first = t * tile_rows, rows = std::min(tile_rows, x.rows() - first);
      const Matrix at = x.middleRows(first, rows).template cast<T>();
      Matrix raw(rows, m), pulled(rows, n);
      tile.forward(rows, at.data(), nullptr, raw.data(), nullptr);
      finish(at, raw);
      value.segment(first, rows) =
          is_sum_of_squares(head_) ? Vector(raw.rowwise().squaredNorm().template cast<double>() +
                                            quadratic_ * x.middleRows(first, rows).rowwise().squaredNorm())
                                   : Vector(raw.col(0).template cast<double>());
      const Matrix adjoint = is_sum_of_squares(head_) ? Matrix(T(2) * raw) : Matrix(Matrix::Ones(rows, 1));
      tile.pull_back(adjoint.data(), pulled.data());
      if (head_ == Head::diffeomorphism) pulled += adjoint;
      gradient.middleRows(first, rows) =
          pulled.template cast<double>() + 2.0 * quadratic_ * x.middleRows(first, rows);
    }
  };
  if (x.rows() * network_.parameters() < kLeastParallelWork) return run(0, tiles);
  const Eigen::Index parts = std::min(tiles, kPartsPerThread * static_cast<Eigen::Index>(thread_count()));
  parallel_for(parts, [&](Eigen::Index part, int) { run(tiles * part / parts, tiles * (part + 1) / parts); });
}

template class BasicEvaluator<float>;
template class BasicEvaluator<double>;

}  // namespace s2nnds
