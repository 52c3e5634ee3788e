// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/certificate.h"

namespace s2nnds {
namespace {

const Range kCount = at_least(0);

}  // namespace

void ConditionVerdict::visit(FieldVisitor& v) {
  visit_enum(v, "condition", condition);
  visit_enum(v, "method", method);
  visit_enum(v, "verdict", verdict);
  v.field("samples", samples, kCount);
  v.field("violations", violations, kCount);
  v.field("seed", seed, any_number());
  v.field("worst", worst, any_number());
  v.field("epsilon", epsilon, between(0, 1));
  v.field("beta", beta, between(0, 1));
  v.field("attempt", attempt, kCount);
  v.field("order", order, kCount);
  v.field("quantile", quantile, any_number());
  v.field("tightest_epsilon", tightest_epsilon, between(0, 1));
  v.field("boxes", boxes, kCount);
  v.field("open_boxes", open_boxes, kCount);
  v.field("open_volume", open_volume, at_least(0));
  v.field("witness", witness, any_number());
  v.field("reason", reason);
  v.field("seconds", seconds, at_least(0));
}

void SideConditions::visit(FieldVisitor& v) {
  v.field("goal_is_equilibrium", goal_is_equilibrium);
  v.field("lyapunov_vanishes_at_goal", lyapunov_vanishes_at_goal);
  v.field("goal_is_safe", goal_is_safe);
  v.field("initial_in_workspace", initial_in_workspace);
}

void ExecutionCertificate::visit(FieldVisitor& v) {
  v.field("model", model);
  v.field("reason", reason);
  v.field("invariant", invariant);
  v.field("speed", speed, above(0));
  v.field("convergence_radius", convergence_radius, at_least(0));
  v.field("most_command", most_command, at_least(0));
  v.field("least_speed", least_speed, at_least(0));
  v.field("most_speed", most_speed, at_least(0));
  v.field("most_speed_command", most_speed_command, at_least(0));
  v.field("shielded", shielded);
  v.field("shield_band", shield_band, at_least(0));
  v.field("shield_cone", shield_cone, at_least(0));
  v.field("damping", damping, at_least(0));
  v.field("least_push", least_push, at_least(0));
}

void OrientationCertificate::visit(FieldVisitor& v) {
  v.field("proved", proved);
  v.field("bound", bound, at_least(0));
  v.field("initial_error", initial_error, at_least(0));
  v.field("rate", rate, at_least(0));
  v.field("boxes", boxes, kCount);
  v.field("reason", reason);
  v.field("tool", tool);
  v.field("tool_clear", tool_clear);
}

void StabilityCertificate::visit(FieldVisitor& v) {
  v.field("proved", proved);
  v.field("decay", decay, at_least(0));
  v.field("lipschitz", lipschitz, at_least(0));
  v.field("overshoot", overshoot, at_least(0));
  v.field("reason", reason);
}

void Certificate::visit(FieldVisitor& v) {
  visit_enum(v, "guarantee", guarantee);
  v.field("weight_hash", weight_hash);
  v.field("scope", scope);
  v.field("seal", seal);
  v.field("attempts", attempts, kCount);
  v.field("level_band", level_band, at_least(0));
  v.field("disturbance_margin", disturbance_margin, at_least(0));
  v.field("convergence_radius", convergence_radius, at_least(0));
  v.field("float32_error", float32_error, any_number());
  v.field("barrier_float32_error", barrier_float32_error, any_number());
  v.field("barrier_float64_error", barrier_float64_error, any_number());
  v.field("statement", statement);
  v.group("execution", execution);
  v.group("orientation", orientation);
  v.group("stability", stability);
  side.visit(v);
  v.list("conditions", conditions);
}

}  // namespace s2nnds
