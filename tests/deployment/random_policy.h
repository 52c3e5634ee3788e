// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "s2nnds/core/random.h"
#include "s2nnds/deployment/export_format.h"
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

// A policy of these networks, none of what it carries a default; the texts need quoting wherever they are
// written.
inline Policy random_policy(const Networks& networks) {
  Policy policy;
  policy.networks = networks;
  PolicyInfo& info = policy.info;
  info.name = "Loop \"1\"\\";
  info.unit = "mm";
  info.guarantee = "conformal";
  info.statement = "Line one,\nline \"two\" ?\?/ \\";
  info.weight_hash = weight_hash(networks);
  info.dimension = networks.f.input_dimension();
  info.position_scale = 40.0;
  info.velocity_scale = 25.0;
  info.workspace.assign(static_cast<std::size_t>(info.dimension), -50.0);
  info.workspace.resize(2 * info.workspace.size(), 60.0);
  info.disturbance_margin = 6.25;
  info.convergence_radius = 3.5;
  info.float32_error = 2.5e-4;
  return policy;
}

inline void write_policy(const Networks& networks, std::string_view format, const std::string& path,
                         HeaderPrecision precision = HeaderPrecision::float32) {
  export_policy(random_policy(networks), export_format_from(format), {precision}, path);
}

}  // namespace s2nnds
