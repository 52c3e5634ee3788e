// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/evaluator.h"

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

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
  raw.rowwise() -= at_origin_.row(0);
  if (head_ != Head::squared_norm) return raw.template cast<double>();
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
  raw.rowwise() -= at_origin_.row(0);
  if (head_ != Head::squared_norm) {
    value = raw.template cast<double>();
    derivative = tangent.template cast<double>();
    return;
  }
  value = raw.rowwise().squaredNorm().template cast<double>() + quadratic_ * x.rowwise().squaredNorm();
  derivative = 2.0 * (raw.cwiseProduct(tangent).rowwise().sum().template cast<double>() +
                      quadratic_ * x.cwiseProduct(direction).rowwise().sum());
}

template class BasicEvaluator<float>;
template class BasicEvaluator<double>;

}  // namespace s2nnds
