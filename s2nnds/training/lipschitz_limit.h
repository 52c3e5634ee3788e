// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/networks/fused_network.h"

namespace s2nnds {

// Keeps the product of the layers' spectral norms of a network at a limit, from step to step of a training. The norms
// are estimated by power iteration that goes on from where the last call left it: from below, and soon exactly.
// verification/lipschitz_bound.h bounds the product from above.
class LipschitzLimit {
 public:
  // `limit` > 0. The iteration starts from fixed vectors.
  LipschitzLimit(std::vector<LayerShape> layers, double limit);

  // If the product exceeds the limit, all weights of the flat parameters (FusedNetwork::load) are scaled by one
  // factor, so that it does not. `iterations` >= 1 are made for each layer.
  void keep(float* parameters, int iterations);

 private:
  std::vector<LayerShape> layers_;
  double limit_;
  std::vector<Eigen::VectorXf> directions_;  // of each layer's largest gain, [inputs], unit vectors
};

}  // namespace s2nnds
