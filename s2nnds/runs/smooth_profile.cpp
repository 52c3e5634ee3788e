// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/smooth_profile.h"

namespace s2nnds {
namespace {

MlpOptions smooth_network(const std::vector<std::int64_t>& hidden) {
  return {.hidden = hidden, .first_layer_gain = 1.5, .first_layer_bias = 0.5};
}

}  // namespace

void make_smooth(Config& config) {
  config.networks.f.network = smooth_network({32, 32, 32});
  config.networks.B = {.network = smooth_network({32, 32}), .wall_slope = 0.0};

  TrainerOptions& training = config.training;
  training.steps = 500;
  training.obstacle_margin = 0.05;
  // A level that samples find free leaves no room at the corners of the workspace, which they hardly ever meet.
  training.max_level_shift = 0.0;
  training.batch.workspace = 384;
  training.batch.unsafe = 256;
  LossOptions& loss = training.loss;
  loss.weight[LossTerm::barrier_sets] = 5.0;
  loss.weight[LossTerm::rollout_safety] = 0.5;
  loss.decay_rate = 0.2;
  loss.margin_initial = loss.margin_unsafe = loss.margin_barrier_decrease = 0.1;
}

}  // namespace s2nnds
