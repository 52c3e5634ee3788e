// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/trainer_options.h"

namespace s2nnds {

void WarmStartOptions::visit(FieldVisitor& v) {
  v.field("steps", steps, at_least(1));
  v.field("rate", rate, above(0.0));
  v.field("weight_decay", weight_decay, at_least(0.0));
  v.field("attempts", attempts, at_least(1));
}

void LossOptions::visit(FieldVisitor& v) {
  for (const LossTerm term : all_loss_terms)
    v.field(std::string(to_string(term)), weight[term], at_least(0.0));
  v.field("margin_initial", margin_initial, at_least(0.0));
  v.field("margin_unsafe", margin_unsafe, at_least(0.0));
  v.field("margin_barrier_decrease", margin_barrier_decrease, at_least(0.0));
  if (kind == "paper") {
    v.field("margin_positive", margin_positive, at_least(0.0));
    v.field("margin_decrease", margin_decrease, any_number());
    v.field("leak", leak, between(0.0, 1.0));
    return;
  }
  v.field("decay_rate", decay_rate, at_least(0.0));
  v.field("band_width", band_width, above(0.0));
}

void BatchOptions::visit(FieldVisitor& v) {
  v.field("demonstrations", demonstrations, at_least(1));
  v.field("start_jitter", start_jitter, at_least(0.0));
  v.field("workspace", workspace, at_least(1));
  v.field("initial", initial, at_least(1));
  v.field("path", path, at_least(0));
  v.field("unsafe", unsafe, at_least(1));
  v.field("share_counterexamples", share_counterexamples, between(0.0, 1.0));
  v.field("share_band", share_band, between(0.0, 1.0));
  v.field("share_goal", share_goal, between(0.0, 1.0));
}

void TrainerOptions::visit(FieldVisitor& v) {
  v.field("engine", engine, {"fused", "autograd"});
  v.field("rounds", rounds, at_least(1));
  v.field("min_rounds", min_rounds, at_least(1));
  v.field("steps", steps, at_least(1));
  v.field("rate_f", rate_f, above(0.0));
  v.field("rate_certificates", rate_certificates, above(0.0));
  v.field("rate_decay", rate_decay, {.low = 0.0, .high = 1.0, .open_low = true});
  v.field("rate_period", rate_period, at_least(0));
  v.field("barrier_rounds", barrier_rounds, at_least(0));
  v.field("relax_weights", relax_weights);
  v.field("refine", refine);
  v.field("backtrack", backtrack);
  v.field("max_level_shift", max_level_shift, at_least(0.0));
  v.field("imitation_finetune_rounds", imitation_finetune_rounds, at_least(0));
  v.field("enlarge_rounds", enlarge_rounds, at_least(0));
  v.field("enlarge_steps", enlarge_steps, at_least(1));
  v.field("weight_decay", weight_decay, at_least(0.0));
  v.field("rollout_points", rollout_points, at_least(0));
  v.field("smoothing", smoothing, between(0.0, 1.0));
  v.field("start_paths", start_paths, at_least(0.0));
  v.field("funnel", funnel, at_least(0.0));
  v.field("detour", detour, at_least(0.0));
  v.field("obstacle_margin", obstacle_margin, at_least(0.0));
  v.field("samples", samples, at_least(1));
  v.field("level_band", level_band, above(0.0));
  v.field("margin", margin, at_least(0.0));
  v.group("warm_start", warm_start);
  v.group("loss", loss);
  v.group("batch", batch);
}

TrainerOptions paper_training() {
  TrainerOptions options;
  options.rollout_points = 0;
  options.min_rounds = 5;
  options.steps = 500;
  options.refine = options.backtrack = options.relax_weights = false;
  options.imitation_finetune_rounds = options.enlarge_rounds = options.rate_period = 0;
  options.rate_certificates = 3e-3;
  options.max_level_shift = 0.0;
  options.smoothing = options.start_paths = options.funnel = options.detour = options.obstacle_margin =
      options.batch.start_jitter = 0.0;
  options.weight_decay = 0.0;
  options.warm_start = {.steps = 20000, .rate = 2e-3, .weight_decay = 0.0};
  options.loss = {.kind = "paper",
                  .weight = {{10.0, 1.0, 1.0, 1.0, 0.0, 0.0}},
                  .margin_initial = 0.01,
                  .margin_unsafe = 0.01,
                  .margin_barrier_decrease = 0.0,
                  .leak = 0.01};
  options.batch.demonstrations = options.batch.workspace = 512;
  options.batch.initial = options.batch.unsafe = 64;
  options.batch.path = 0;
  options.batch.share_band = options.batch.share_goal = 0.0;
  return options;
}

TrainerOptions imitation_training() {
  TrainerOptions options;
  options.rounds = options.min_rounds = 5;
  options.steps = 500;
  options.batch.demonstrations = 512;
  options.start_paths = options.funnel = options.detour = 0.0;
  options.rollout_points = 0;
  options.refine = false;
  options.imitation_finetune_rounds = options.enlarge_rounds = 0;
  options.samples = 1000;                                              // what they find trains nothing
  options.loss.weight = {{options.loss.weight[LossTerm::imitation]}};  // the others are 0
  return options;
}

}  // namespace s2nnds
