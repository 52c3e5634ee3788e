// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/rounding_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/verification/standard_floating_point.h"

namespace s2nnds {
namespace {

// The roundings, in double, of sums of non-negative numbers over a layer's neurons, up to a million of them.
constexpr double layer_slack = 1.0 + 1e-9;
constexpr Eigen::Index kTogether = 64;  // cells that one thread examines together

struct Format {
  double roundoff;  // relative error of one rounding
  double tiny;      // above what gradual underflow loses, summed over a layer
};
constexpr Format single = {0x1p-24, 1e-35}, twice = {0x1p-53, 1e-300};

double lipschitz(Activation activation) { return activation == Activation::silu ? 1.1 : 1.0; }

// Above |sigma(z)| for |z| <= size.
double activation_size(Activation activation, double size) {
  switch (activation) {
    case Activation::tanh:
    case Activation::sine:
      return std::min(1.0, size);
    case Activation::elu:
    case Activation::softplus:
      return size + 0.7;
    case Activation::identity:
    case Activation::silu:
      break;
  }
  return size;
}

// A layer, with the sizes of its weights.
struct SizedLayer {
  Points weight, size;  // [outputs, inputs]
  Vector bias;          // [outputs]
  Activation activation;
};

std::vector<SizedLayer> sized(const NetworkWeights& network) {
  std::vector<SizedLayer> layers;
  for (const Layer& layer : network.layers) {
    layers.push_back({layer.weight, layer.weight.cwiseAbs(),
                      layer.bias.size() > 0 ? layer.bias : Vector::Zero(layer.weight.rows()),
                      layer.activation});
  }
  return layers;
}

// |computed y - y| for each output at boxes around `center`.
Vector propagate(const std::vector<SizedLayer>& layers, const Format& format, const Vector& center,
                 const Vector& half) {
  Vector middle = center, reach = half;  // a lies within middle +- reach
  Vector error = 6.0 * format.roundoff * (center.cwiseAbs() + half);
  error.array() += format.tiny;
  for (const SizedLayer& layer : layers) {
    const Points& size = layer.size;
    const Vector& bias = layer.bias;
    const Vector largest = middle.cwiseAbs() + reach + error;
    const double rounding = 1.01 * (static_cast<double>(layer.weight.cols()) + 4.0) * format.roundoff;
    error = layer_slack * (size * error + rounding * (size * largest + bias.cwiseAbs()));
    error.array() += format.tiny;
    reach = layer_slack * (size * reach);
    reach.array() += 1e-12 * (size * middle.cwiseAbs() + bias.cwiseAbs()).array();
    middle = layer.weight * middle + bias;
    if (layer.activation == Activation::identity) continue;
    for (Eigen::Index i = 0; i < error.size(); ++i) {
      const double low = middle(i) - reach(i) - error(i), high = middle(i) + reach(i) + error(i);
      const double farthest = std::max(std::abs(low), std::abs(high));
      double slope = lipschitz(layer.activation), nearest = low > 0.0 ? low : (high < 0.0 ? -high : 0.0);
      if (layer.activation == Activation::tanh) {  // falls with |z|
        const double t = std::max(0.0, std::tanh(nearest) - 1e-12);
        slope = 1.0 - t * t;
        const double a = std::tanh(low), b = std::tanh(high);
        middle(i) = 0.5 * (a + b);
        reach(i) = 0.5 * (b - a) + 1e-12;
      } else {
        middle(i) = 0.0;
        reach(i) = activation_size(layer.activation, farthest);
      }
      const double unit = std::max(activation_size(layer.activation, farthest), 1.0);
      error(i) = layer_slack * slope * error(i) + 8.0 * 2.0 * format.roundoff * unit;
    }
  }
  const Vector size = middle.cwiseAbs() + reach + error;
  return error + 4.0 * format.roundoff * size;
}

double largest_error(const NetworkWeights& network, const Format& format, const Box& box) {
  network.check();
  check(!is_sum_of_squares(network.head),
        "rounding error: found the head {}, expected plain or zero_at_origin", to_string(network.head));
  const Eigen::Index n = box.dimension();
  check(n == network.input_dimension() && box.is_finite(),
        "rounding error: expected a bounded box of dimension {}", network.input_dimension());
  // A grid of some 4,000 cells: on small boxes activations are not steeper than they are.
  const auto side = static_cast<Eigen::Index>(std::max(2.0, std::floor(std::pow(4096.0, 1.0 / double(n)))));
  Eigen::Index cells = 1;
  for (Eigen::Index d = 0; d < n; ++d) cells *= side;
  const std::vector<SizedLayer> layers = sized(network);
  const StandardFloatingPoint mode;
  const Vector offset = network.head == Head::zero_at_origin
                            ? propagate(layers, format, Vector::Zero(n), Vector::Zero(n))
                            : Vector::Zero(network.output_dimension());
  const Vector half = (box.upper - box.lower) / (2.0 * double(side)) * layer_slack;
  const auto error_in = [&](Eigen::Index cell) {
    Vector center(n);
    for (Eigen::Index d = 0, rest = cell; d < n; ++d, rest /= side) {
      center(d) = box.lower(d) + (box.upper(d) - box.lower(d)) * (double(rest % side) + 0.5) / double(side);
    }
    const double found = (propagate(layers, format, center, half) + offset).norm();
    return std::isnan(found) ? std::numeric_limits<double>::infinity() : found;
  };
  std::vector<double> largest(static_cast<std::size_t>((cells + kTogether - 1) / kTogether), 0.0);
  parallel_for(std::ssize(largest), [&](std::ptrdiff_t part, int) {
    const StandardFloatingPoint same_mode;  // of this thread
    double& here = largest[static_cast<std::size_t>(part)];
    for (Eigen::Index cell = part * kTogether; cell < std::min(cells, (part + 1) * kTogether); ++cell)
      here = std::max(here, error_in(cell));
  });
  return *std::max_element(largest.begin(), largest.end()) * layer_slack;
}

}  // namespace

double float32_error(const NetworkWeights& network, const Box& box) {
  return largest_error(network, single, box);
}

double float64_error(const NetworkWeights& network, const Box& box) {
  return largest_error(network, twice, box);
}

double Float32Error::of(const NetworkWeights& network, const Box& box) {
  std::string hash = weight_hash({network, {}, {}});
  if (hash != network_) error_ = float32_error(network, box);
  network_ = std::move(hash);
  return error_;
}

}  // namespace s2nnds
