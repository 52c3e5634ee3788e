#include "s2nnds/networks/evaluator.h"

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

FusedNetwork<double> pack(const LayerStack& stack) {
  stack.check();
  std::vector<LayerShape> shapes;
  std::vector<double> parameters;
  for (const Layer& layer : stack.layers) {
    shapes.push_back({layer.weight.cols(), layer.weight.rows(), layer.bias.size() > 0, layer.activation});
    parameters.insert(parameters.end(), layer.weight.data(), layer.weight.data() + layer.weight.size());
    parameters.insert(parameters.end(), layer.bias.data(), layer.bias.data() + layer.bias.size());
  }
  FusedNetwork<double> network(shapes);
  network.load(parameters.data());
  return network;
}

}  // namespace

Evaluator::Evaluator(const LayerStack& stack)
    : network_(pack(stack)), head_(stack.head), quadratic_(stack.quadratic) {
  at_origin_.setZero(network_.outputs());
  if (head_ != Head::plain) {
    const Vector zero = Vector::Zero(network_.inputs());
    network_.forward(1, zero.data(), nullptr, at_origin_.data(), nullptr, nullptr);
  }
}

Points Evaluator::value(const Points& x) const {
  check(x.cols() == input_dimension(), "network: found points of dimension {}, expected {}", x.cols(),
        input_dimension());
  Points raw(x.rows(), network_.outputs());
  network_.forward(x.rows(), x.data(), nullptr, raw.data(), nullptr, nullptr);
  raw.rowwise() -= at_origin_;
  if (head_ != Head::squared_norm) return raw;
  return raw.rowwise().squaredNorm() + quadratic_ * x.rowwise().squaredNorm();
}

void Evaluator::value_and_derivative(const Points& x, const Points& direction, Points& value,
                                     Points& derivative) const {
  check(
      x.cols() == input_dimension() && direction.cols() == input_dimension() && direction.rows() == x.rows(),
      "network: found points [{}, {}] and directions [{}, {}], expected both [N, {}]", x.rows(), x.cols(),
      direction.rows(), direction.cols(), input_dimension());
  Points raw(x.rows(), network_.outputs()), tangent(x.rows(), network_.outputs());
  network_.forward(x.rows(), x.data(), direction.data(), raw.data(), tangent.data(), nullptr);
  raw.rowwise() -= at_origin_;
  if (head_ != Head::squared_norm) {
    value = std::move(raw);
    derivative = std::move(tangent);
    return;
  }
  value = raw.rowwise().squaredNorm() + quadratic_ * x.rowwise().squaredNorm();
  derivative = 2.0 * (raw.cwiseProduct(tangent).rowwise().sum() +
                      quadratic_ * x.cwiseProduct(direction).rowwise().sum());
}

}  // namespace s2nnds
