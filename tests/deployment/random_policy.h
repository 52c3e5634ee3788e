#pragma once

#include <cmath>
#include <vector>

#include "s2nnds/core/random.h"
#include "s2nnds/deployment/policy_info.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// Layers of random weights; `exact_in_float`: weights that float32 holds exactly, so that evaluating an
// export in double is exact too.
inline NetworkWeights random_stack(const std::vector<int>& sizes, Activation activation, bool bias,
                                   bool exact_in_float, RandomStream& random) {
  NetworkWeights stack;
  for (std::size_t l = 0; l + 1 < sizes.size(); ++l) {
    const auto draw = [&] {
      const double value = random.normal() / std::sqrt(sizes[l]);
      return exact_in_float ? static_cast<double>(static_cast<float>(value)) : value;
    };
    Layer layer;
    layer.weight = Points::NullaryExpr(sizes[l + 1], sizes[l], draw);
    if (bias) layer.bias = Vector::NullaryExpr(sizes[l + 1], draw);
    layer.activation = l + 2 < sizes.size() ? activation : Activation::identity;
    stack.layers.push_back(layer);
  }
  return stack;
}

// What a policy carries, none of it a default; the texts need quoting wherever they are written.
inline PolicyInfo random_policy_info(int n) {
  PolicyInfo info;
  info.name = "Loop \"1\"\\";
  info.position_scale = 40.0;
  info.velocity_scale = 25.0;
  info.unit = "mm";
  info.guarantee = "conformal";
  info.statement = "Line one,\nline \"two\" ?\?/ \\";
  info.workspace_lower = Vector::Constant(n, -1.25);
  info.workspace_upper = Vector::Constant(n, 1.5);
  info.disturbance_margin = 0.25;
  info.float32_error = 1e-5;
  return info;
}

}  // namespace s2nnds
