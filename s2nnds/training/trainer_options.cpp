#include "s2nnds/training/trainer_options.h"

namespace s2nnds {

void WarmStartOptions::visit(FieldVisitor& v) {
  v.field("steps", steps, at_least(1));
  v.field("batch", batch, at_least(1));
  v.field("rate", rate, above(0.0));
  v.field("weight_decay", weight_decay, at_least(0.0));
  v.field("clip", clip, above(0.0));
  v.field("attempts", attempts, at_least(1));
  v.field("stalled", stalled, above(0.0));
}

void LossOptions::visit(FieldVisitor& v) {
  v.field("kind", kind, {"robust", "paper"});
  v.field("mse", mse, at_least(0.0));
  v.field("lyapunov", lyapunov, at_least(0.0));
  v.field("separation", separation, at_least(0.0));
  v.field("band", band, at_least(0.0));
  v.field("margin_initial", margin_initial, at_least(0.0));
  v.field("margin_unsafe", margin_unsafe, at_least(0.0));
  v.field("margin_band", margin_band, at_least(0.0));
  if (kind == "paper") {
    v.field("margin_positive", margin_positive, at_least(0.0));
    v.field("margin_decrease", margin_decrease, any_number());
    v.field("leak", leak, between(0.0, 1.0));
    return;
  }
  v.field("labels", labels, at_least(0.0));
  v.field("deflection", deflection, at_least(0.0));
  v.field("kappa", kappa, at_least(0.0));
  v.field("band_width", band_width, above(0.0));
  v.field("margin_label", margin_label, at_least(0.0));
  v.field("margin_deflection", margin_deflection, at_least(0.0));
}

void BatchOptions::visit(FieldVisitor& v) {
  v.field("demonstrations", demonstrations, at_least(1));
  v.field("start_jitter", start_jitter, at_least(0.0));
  v.field("workspace", workspace, at_least(1));
  v.field("initial", initial, at_least(1));
  v.field("unsafe", unsafe, at_least(1));
  v.field("shell", shell, at_least(1));
  v.field("labels", labels, at_least(2));
  v.field("upstream", upstream, at_least(1));
  v.field("corrections", corrections, at_least(1));
  v.field("boundary", boundary, at_least(1));
  v.field("share_counterexamples", share_counterexamples, between(0.0, 1.0));
  v.field("share_band", share_band, between(0.0, 1.0));
  v.field("share_goal", share_goal, between(0.0, 1.0));
  v.field("band_near", band_near, above(0.0));
  v.field("band_refresh", band_refresh, at_least(1));
}

void TrainerOptions::visit(FieldVisitor& v) {
  v.field("engine", engine, {"fused", "autograd"});
  v.field("rounds", rounds, at_least(1));
  v.field("min_rounds", min_rounds, at_least(1));
  v.field("steps", steps, at_least(1));
  v.field("rate_f", rate_f, above(0.0));
  v.field("rate_certificates", rate_certificates, above(0.0));
  v.field("rate_decay", rate_decay, {.low = 0.0, .high = 1.0, .open_low = true});
  v.field("rate_end", rate_end, between(0.0, 1.0));
  v.field("rate_floor", rate_floor, between(0.0, 1.0));
  v.field("rate_rise", rate_rise, at_least(1));
  v.field("rate_period", rate_period, at_least(1));
  v.field("redraw_barrier", redraw_barrier);
  v.field("restart_mse", restart_mse, between(0.0, 1.0));
  v.field("restart_labels", restart_labels, between(0.0, 1.0));
  v.field("mend_rounds", mend_rounds, at_least(0));
  v.field("mend_below", mend_below, at_least(1));
  v.field("mend_rate", mend_rate, above(0.0));
  v.field("mend_labels", mend_labels, between(0.0, 1.0));
  v.field("mend_band", mend_band, at_least(0.0));
  v.field("repair_motions", repair_motions, at_least(0));
  v.field("repair_gain", repair_gain, at_least(0.0));
  v.field("level_reach", level_reach, at_least(0.0));
  v.field("polish_rounds", polish_rounds, at_least(0));
  v.field("polish_mse", polish_mse, at_least(0.0));
  v.field("polish_rate", polish_rate, above(0.0));
  v.field("growth_rounds", growth_rounds, at_least(0));
  v.field("growth_labels", growth_labels, at_least(0.0));
  v.field("growth_margins", growth_margins, at_least(0.0));
  v.field("growth_rate", growth_rate, above(0.0));
  v.field("clip", clip, above(0.0));
  v.field("weight_decay", weight_decay, at_least(0.0));
  v.field("label_points", label_points, at_least(0));
  v.field("smoothing", smoothing, between(0.0, 1.0));
  v.field("tube", tube, at_least(0.0));
  v.field("keep_clear", keep_clear, at_least(0.0));
  v.field("samples", samples, at_least(1));
  v.field("pool_additions", pool_additions, at_least(1));
  v.field("pool_capacity", pool_capacity, at_least(1));
  v.field("band", band, above(0.0));
  v.group("warm_start", warm_start);
  v.group("loss", loss);
  v.group("batch", batch);
}

TrainerOptions paper_training() {
  TrainerOptions options;
  options.label_points = 0;
  options.mend_rounds = options.repair_motions = options.polish_rounds = options.growth_rounds = 0;
  options.rate_certificates = 3e-3;
  options.rate_rise = 1;
  options.redraw_barrier = false;
  options.restart_mse = options.restart_labels = 1.0;
  options.level_reach = 0.0;
  options.smoothing = options.keep_clear = options.batch.start_jitter = 0.0;
  options.weight_decay = options.warm_start.weight_decay = 0.0;
  options.loss = {.kind = "paper",
                  .mse = 10.0,
                  .lyapunov = 1.0,
                  .separation = 1.0,
                  .band = 1.0,
                  .deflection = 0.0,
                  .margin_initial = 0.01,
                  .margin_unsafe = 0.01,
                  .margin_band = 0.0};
  options.batch.initial = options.batch.unsafe = options.batch.shell = 64;
  options.batch.share_band = options.batch.share_goal = 0.0;
  return options;
}

}  // namespace s2nnds
