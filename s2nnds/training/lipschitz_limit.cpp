// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/lipschitz_limit.h"

#include <cmath>

namespace s2nnds {
namespace {

using Weight = Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

// The gain |W v| of the direction v, which is iterated first.
double gain(const Weight& weight, Eigen::VectorXf& direction, int iterations) {
  for (int i = 0; i < iterations; ++i) {
    const Eigen::VectorXf next = weight.transpose() * (weight * direction);
    const float size = next.norm();
    if (!(size > 0.0F)) return 0.0;  // of a weight that is 0, or not a number
    direction = next / size;
  }
  return static_cast<double>((weight * direction).norm());
}

}  // namespace

LipschitzLimit::LipschitzLimit(std::vector<LayerShape> layers, double limit)
    : layers_(std::move(layers)), limit_(limit) {
  for (const LayerShape& layer : layers_) {
    Eigen::VectorXf start(layer.inputs);
    for (Eigen::Index i = 0; i < start.size(); ++i) start[i] = std::cos(static_cast<float>(i + 1));
    directions_.push_back(start.normalized());
  }
}

void LipschitzLimit::keep(float* parameters, int iterations) {
  double product = 1.0;
  float* at = parameters;
  for (std::size_t l = 0; l < layers_.size(); at += layers_[l++].parameters())
    product *= gain(Weight(at, layers_[l].outputs, layers_[l].inputs), directions_[l], iterations);
  if (!(product > limit_)) return;
  const auto factor =
      static_cast<float>(std::pow(limit_ / product, 1.0 / static_cast<double>(layers_.size())));
  for (const LayerShape& layer : layers_) {
    Weight(parameters, layer.outputs, layer.inputs) *= factor;
    parameters += layer.parameters();
  }
}

}  // namespace s2nnds
