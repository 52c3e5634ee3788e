// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <torch/nn/module.h>
#include <torch/nn/pimpl.h>
#include <torch/types.h>

#include <cstdint>
#include <vector>

#include "s2nnds/core/random.h"
#include "s2nnds/networks/fused_network.h"
#include "s2nnds/networks/network_options.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// A fully connected network as a torch::nn module. All weights live in one flat parameter `theta` (per layer
// the weight [out, in] row-major, then the bias [out]), so that an optimiser step is a handful of operations.
class MlpImpl : public torch::nn::Module {
 public:
  // Xavier uniform weights; throws Error on a bad size. dtype: torch::kFloat32 or kFloat64.
  MlpImpl(std::int64_t inputs, std::int64_t outputs, const MlpOptions& options, RandomStream& random,
          torch::Dtype dtype = torch::kFloat32);

  // x [N, n] -> N(x) [N, m].
  torch::Tensor forward(torch::Tensor x);
  torch::Tensor theta;  // all weights: [parameters]

  std::int64_t inputs() const { return shapes_.front().inputs; }     // n
  std::int64_t outputs() const { return shapes_.back().outputs; }    // m
  const std::vector<LayerShape>& shapes() const { return shapes_; }  // of the layers, the first one first
  std::vector<Layer> layers() const;                                 // the weights as doubles
  void set_layers(const std::vector<Layer>& layers);                 // throws Error if the shapes differ

 private:
  std::vector<LayerShape> shapes_;
};
// Holds an MlpImpl; copies share it.
TORCH_MODULE(Mlp);

// sigma(z), element by element, by ATen.
torch::Tensor activate(Activation activation, const torch::Tensor& z);

}  // namespace s2nnds
