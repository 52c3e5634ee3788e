// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/mlp.h"

#include <torch/nn/functional/linear.h>
#include <torch/utils.h>

#include "s2nnds/core/check.h"

namespace s2nnds {

torch::Tensor activate(Activation activation, const torch::Tensor& z) {
  switch (activation) {
    case Activation::identity:
      return z;
    case Activation::tanh:
      return torch::tanh(z);
    case Activation::elu:
      return torch::elu(z);
    case Activation::softplus:
      return torch::softplus(z, 1, 40);
    case Activation::silu:
      return torch::silu(z);
    case Activation::sine:
      return torch::sin(z);
  }
  fail("activation: found the unknown value {}", static_cast<int>(activation));
}

MlpImpl::MlpImpl(std::int64_t inputs, std::int64_t outputs, const MlpOptions& options, RandomStream& random,
                 torch::Dtype dtype) {
  check(inputs > 0 && outputs > 0, "network: found {} inputs and {} outputs, expected at least one each",
        inputs, outputs);
  std::int64_t from = inputs, count = 0;
  for (std::size_t l = 0; l <= options.hidden.size(); ++l) {
    const bool last = l == options.hidden.size();
    const std::int64_t to = last ? outputs : options.hidden[l];
    check(to > 0, "network: layer {} has {} neurons, expected at least one", l, to);
    shapes_.push_back(
        {from, to, options.bias, activation_from(last ? options.output_activation : options.activation)});
    count += shapes_.back().parameters();
    from = to;
  }
  std::vector<double> start;
  start.reserve(count);
  for (std::size_t l = 0; l < shapes_.size(); ++l) {
    const LayerShape& shape = shapes_[l];
    const double gain = l == 0 ? options.first_layer_gain : 1.0;
    const double bound = gain * std::sqrt(6.0 / static_cast<double>(shape.inputs + shape.outputs));  // Xavier
    for (std::ptrdiff_t i = 0; i < shape.inputs * shape.outputs; ++i)
      start.push_back(random.uniform(-bound, bound));
    if (!shape.bias) continue;
    for (std::ptrdiff_t i = 0; i < shape.outputs; ++i) {
      start.push_back(l == 0 && options.first_layer_bias > 0 ? options.first_layer_bias * random.normal()
                                                             : 0.0);
    }
  }
  theta = register_parameter("theta", torch::tensor(start, torch::kFloat64).to(dtype));
}

torch::Tensor MlpImpl::forward(torch::Tensor x) {
  std::int64_t at = 0;
  const auto take = [&](std::int64_t count) {
    at += count;
    return theta.narrow(0, at - count, count);
  };
  for (const LayerShape& shape : shapes_) {
    const torch::Tensor weight = take(shape.inputs * shape.outputs).view({shape.outputs, shape.inputs});
    const torch::Tensor bias = shape.bias ? take(shape.outputs) : torch::Tensor();
    x = activate(shape.activation, torch::nn::functional::linear(x, weight, bias));
  }
  return x;
}

std::vector<Layer> MlpImpl::layers() const {
  const torch::Tensor flat = theta.detach().to(torch::kFloat64).contiguous();
  const double* from = flat.data_ptr<double>();
  std::vector<Layer> all;
  for (const LayerShape& shape : shapes_) {
    Layer layer;
    layer.weight = Eigen::Map<const Points>(from, shape.outputs, shape.inputs);
    from += layer.weight.size();
    if (shape.bias) layer.bias = Eigen::Map<const Vector>(from, shape.outputs);
    from += layer.bias.size();
    layer.activation = shape.activation;
    all.push_back(std::move(layer));
  }
  return all;
}

void MlpImpl::set_layers(const std::vector<Layer>& layers) {
  check(layers.size() == shapes_.size(), "network: found {} layers, expected {}", layers.size(),
        shapes_.size());
  std::vector<double> flat;
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const Layer& layer = layers[l];
    const LayerShape& shape = shapes_[l];
    check(layer.weight.rows() == shape.outputs && layer.weight.cols() == shape.inputs &&
              layer.bias.size() == (shape.bias ? shape.outputs : 0) && layer.activation == shape.activation,
          "network: layer {} is [{}, {}] {}, expected [{}, {}] {}", l, layer.weight.rows(),
          layer.weight.cols(), to_string(layer.activation), shape.outputs, shape.inputs,
          to_string(shape.activation));
    flat.insert(flat.end(), layer.weight.data(), layer.weight.data() + layer.weight.size());
    flat.insert(flat.end(), layer.bias.data(), layer.bias.data() + layer.bias.size());
  }
  torch::NoGradGuard no_grad;
  theta.copy_(torch::tensor(flat, torch::kFloat64));
}

}  // namespace s2nnds
