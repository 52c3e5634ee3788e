// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "s2nnds/core/random.h"
#include "s2nnds/deployment/export_format.h"
#include "s2nnds/networks/network_weights.h"
#include "s2nnds/verification/rounding_error.h"

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

// Where the goal of a random policy lies, far from the origin, up to 7-D.
inline Vector far_goal(Eigen::Index n) {
  return Vector{{512.0, -256.0, 384.0, 128.0, -64.0, 320.0, -448.0}}.head(n);
}

// The positions of normalised points in the data's frame of a random policy.
inline Points positions(const Points& normalised) {
  return (40.0 * normalised).rowwise() + far_goal(normalised.cols()).transpose();
}

// A policy of these networks, none of what it carries a default; the texts need quoting wherever they are
// written.
inline Policy random_policy(const Networks& networks) {
  Policy policy;
  policy.networks = networks;
  PolicyInfo& info = policy.info;
  info.name = "Loop \"1\"\\";
  info.unit = "mm";
  info.frame_name = "base_link";
  info.unsafe_set = "ball centre (1, 2) radius 3";
  info.initial_set = "box lower (4, 5) upper (6, 7)";
  info.guarantee = "conformal";
  info.statement = "Line one,\nline \"two\" ?\?/ \\";
  info.weight_hash = weight_hash(networks);
  info.dimension = networks.f.input_dimension();
  info.position_scale = 40.0;
  info.velocity_scale = 25.0;
  const Vector goal = far_goal(info.dimension);
  info.goal.assign(goal.begin(), goal.end());
  for (const double side : {-50.0, 60.0}) {
    for (const double coordinate : goal) info.workspace.push_back(coordinate + side);
  }
  info.disturbance_margin = 6.25;
  info.convergence_radius = 3.5;
  info.float32_error = 2.5e-4;
  info.decay = networks.decay * info.velocity_scale / info.position_scale;
  const Vector corner = Vector::Constant(info.dimension, 1.5);
  info.barrier_float32_error = float32_error(networks.B, {-corner, corner});
  info.barrier_float64_error = float64_error(networks.B, {-corner, corner});
  return policy;
}

inline void write_policy(const Networks& networks, std::string_view format, const std::string& path,
                         HeaderPrecision precision = HeaderPrecision::float32) {
  export_policy(random_policy(networks), export_format_from(format), {precision}, path);
}

}  // namespace s2nnds
