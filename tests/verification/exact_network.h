// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <vector>

#include "s2nnds/core/random.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// Networks in 50-digit arithmetic: what the enclosures must hold.
using Exact = boost::multiprecision::cpp_bin_float_50;
using ExactVector = std::vector<Exact>;

// sigma(z), sigma'(z).
inline Exact exact_activation(Activation activation, const Exact& z) {
  switch (activation) {
    case Activation::identity:
      return z;
    case Activation::tanh:
      return tanh(z);
    case Activation::elu:
      return z > 0 ? z : Exact(exp(z) - 1);
    case Activation::softplus:
      return log(1 + exp(z));
    case Activation::silu:
      return z / (1 + exp(-z));
    case Activation::sine:
      return sin(z);
  }
  return 0;
}
inline Exact exact_slope(Activation activation, const Exact& z) {
  switch (activation) {
    case Activation::identity:
      return 1;
    case Activation::tanh: {
      const Exact t = tanh(z);
      return 1 - t * t;
    }
    case Activation::elu:
      return z > 0 ? Exact(1) : Exact(exp(z));
    case Activation::softplus:
      return 1 / (1 + exp(-z));
    case Activation::silu: {
      const Exact s = 1 / (1 + exp(-z));
      return s + z * s * (1 - s);
    }
    case Activation::sine:
      return cos(z);
  }
  return 0;
}

// y(x) and its derivative along `direction`.
struct ExactValue {
  ExactVector value, rate;
};
inline ExactValue exact_layers(const NetworkWeights& stack, ExactVector x, ExactVector direction) {
  for (const Layer& layer : stack.layers) {
    ExactVector value, rate;
    for (Eigen::Index i = 0; i < layer.weight.rows(); ++i) {
      Exact z = layer.bias.size() > 0 ? layer.bias(i) : 0.0, dz = 0;
      for (Eigen::Index k = 0; k < layer.weight.cols(); ++k) {
        z += layer.weight(i, k) * x[k];
        dz += layer.weight(i, k) * direction[k];
      }
      value.push_back(exact_activation(layer.activation, z));
      rate.push_back(exact_slope(layer.activation, z) * dz);
    }
    x = std::move(value);
    direction = std::move(rate);
  }
  return {x, direction};
}
inline ExactValue exact_network(const NetworkWeights& stack, const ExactVector& x,
                                const ExactVector& direction) {
  ExactValue y = exact_layers(stack, x, direction);
  if (stack.head == Head::plain) return y;
  const ExactValue origin = exact_layers(stack, ExactVector(x.size(), 0), ExactVector(x.size(), 0));
  for (std::size_t i = 0; i < y.value.size(); ++i) y.value[i] -= origin.value[i];
  if (stack.head == Head::zero_at_origin) return y;
  Exact norm = 0, rate = 0;
  for (std::size_t i = 0; i < y.value.size(); ++i) {
    norm += y.value[i] * y.value[i];
    rate += 2 * y.value[i] * y.rate[i];
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    norm += stack.quadratic * x[i] * x[i];
    rate += 2 * stack.quadratic * x[i] * direction[i];
  }
  return {{norm}, {rate}};
}

// Weights of the size that training leaves behind: N(0, gain^2 / inputs), biases N(0, 1/4).
inline NetworkWeights random_stack(const std::vector<Eigen::Index>& widths, Activation activation, Head head,
                                   RandomStream& random, double gain = 1.5) {
  NetworkWeights stack;
  stack.head = head;
  stack.quadratic = head == Head::squared_norm ? 0.05 : 0.0;
  for (std::size_t k = 0; k + 1 < widths.size(); ++k) {
    Layer layer;
    layer.weight.resize(widths[k + 1], widths[k]);
    layer.bias.resize(widths[k + 1]);
    for (double& w : layer.weight.reshaped()) w = gain * random.normal() / std::sqrt(double(widths[k]));
    for (double& b : layer.bias) b = 0.5 * random.normal();
    layer.activation = k + 2 < widths.size() ? activation : Activation::identity;
    stack.layers.push_back(std::move(layer));
  }
  return stack;
}

}  // namespace s2nnds
