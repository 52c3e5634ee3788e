// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/summary.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "s2nnds/core/json_text.h"
#include "s2nnds/data/orientation.h"
#include "s2nnds/runs/motion_report.h"
#include "s2nnds/runs/threads.h"

namespace s2nnds {
namespace {

using nlohmann::ordered_json;

ordered_json real(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr); }

ordered_json json_of(const ConditionVerdict& verdict) {
  ordered_json json = {{"verdict", to_string(verdict.verdict)}};
  if (verdict.method == Method::proof) {
    json.update({{"boxes", verdict.boxes},
                 {"open_boxes", verdict.open_boxes},
                 {"open_volume", verdict.open_volume},
                 {"witness", verdict.witness}});
    if (!verdict.reason.empty()) json["reason"] = verdict.reason;
    return json;
  }
  json.update(
      {{"samples", verdict.samples}, {"violations", verdict.violations}, {"worst", real(verdict.worst)}});
  if (verdict.method == Method::conformal) {
    json.update({{"p", real(verdict.quantile)},
                 {"l", verdict.order},
                 {"epsilon", verdict.epsilon},
                 {"beta", verdict.beta},
                 {"attempt", verdict.attempt},
                 {"tightest_epsilon", verdict.tightest_epsilon}});
  }
  return json;
}

// Every number of a struct by its name in visit; null where it was not measured.
template <typename Figures>
ordered_json json_of_figures(const Figures& figures) {
  return ordered_json::parse(to_json(figures));
}

// The same in the data's unit and frame, for those who compare runs of one motion with what the robot does.
ordered_json in_unit(const RunRecord& record) {
  const Frame& frame = record.data.frame;
  const Box& workspace = record.problem.workspace;
  const EvaluationSummary& e = record.evaluation;
  const Certificate& certificate = record.certificate;
  const double volume = std::pow(frame.position_scale, static_cast<double>(frame.places()));
  const auto position = [](const Vector& x) { return std::vector<double>(x.begin(), x.end()); };
  ordered_json json = {{"unit", frame.unit},
                       {"frame_name", frame.name},
                       {"goal", position(frame.goal)},
                       {"position_scale", frame.position_scale},
                       {"velocity_scale", frame.velocity_scale},
                       {"workspace_lower", position(frame.to_data(workspace.lower))},
                       {"workspace_upper", position(frame.to_data(workspace.upper))},
                       {"velocity_rms_train", real(frame.velocity_scale * std::sqrt(e.mse_train))},
                       {"velocity_rms_test", real(frame.velocity_scale * std::sqrt(e.mse_test))},
                       {"dtw_train", real(frame.position_scale * e.dtw_train)},
                       {"dtw_test", real(frame.position_scale * e.dtw_test)},
                       {"deviation_mean", real(frame.position_scale * e.deviation_mean)},
                       {"deviation_largest", real(frame.position_scale * e.deviation_largest)},
                       {"safe_area", real(volume * e.safe_area)},
                       {"disturbance_margin", real(frame.velocity_scale * certificate.disturbance_margin)},
                       {"convergence_radius", real(frame.position_scale * certificate.convergence_radius)},
                       {"float32_error", real(frame.velocity_scale * certificate.float32_error)}};
  for (const ConditionVerdict& verdict : certificate.conditions) {
    if (verdict.witness.empty()) continue;
    const Vector z = Eigen::Map<const Vector>(verdict.witness.data(), std::ssize(verdict.witness));
    json["violated_at"][std::string(to_string(verdict.condition))] = position(frame.to_data(z));
  }
  return json;
}

}  // namespace

std::string summary_json(const RunRecord& record, const std::string& path) {
  const Certificate& certificate = record.certificate;
  ordered_json json = {{"name", record.name},
                       {"seed", record.seed},
                       {"guarantee", to_string(certificate.guarantee)},
                       {"conditions", ordered_json::object()}};
  for (const ConditionVerdict& verdict : certificate.conditions)
    json["conditions"][std::string(to_string(verdict.condition))][std::string(to_string(verdict.method))] =
        json_of(verdict);
  json["goal_is_equilibrium"] = certificate.side.goal_is_equilibrium;
  json["lyapunov_vanishes_at_goal"] = certificate.side.lyapunov_vanishes_at_goal;
  json["goal_is_safe"] = certificate.side.goal_is_safe;
  json["initial_in_workspace"] = certificate.side.initial_in_workspace;
  json["seconds"] = ordered_json::object();
  const ordered_json timing = json_of_figures(record.timing);
  for (const auto& [name, seconds] : timing.items()) {
    if (!seconds.is_null()) json["seconds"][name] = seconds;
  }
  json.update(json_of_figures(record.evaluation));
  json["disturbance_margin"] = real(certificate.disturbance_margin);
  json["convergence_radius"] = real(certificate.convergence_radius);
  if (const ExecutionCertificate& executed = certificate.execution; !executed.model.empty()) {
    json["execution"] = {{"model", executed.model},
                         {"invariant", executed.invariant},
                         {"convergence_radius", real(executed.convergence_radius)},
                         {"least_speed", real(executed.least_speed)},
                         {"most_speed", real(executed.most_speed)},
                         {"shielded", executed.shielded}};
  }
  if (const ExecutionCertificate& executed = certificate.execution; executed.damping > 0.0)
    json["pushes"] = {{"damping", executed.damping}, {"least_push", executed.least_push}};
  if (const StabilityCertificate& stable = certificate.stability; stable.decay > 0.0) {
    json["stability"] = {{"proved", stable.proved},
                         {"decay", real(stable.decay / record.data.frame.time_scale())},
                         {"lipschitz", real(stable.lipschitz)},
                         {"overshoot", real(stable.overshoot)},
                         {"reason", stable.reason}};
  }
  if (record.data.frame.has_orientation()) {
    const OrientationCertificate& turning = certificate.orientation;
    json["orientation"] = {{"proved", turning.proved},
                           {"bound_degrees", real(degrees(turning.bound))},
                           {"initial_error_degrees", real(degrees(turning.initial_error))},
                           {"rate", real(turning.rate)},
                           {"boxes", turning.boxes},
                           {"reason", turning.reason},
                           {"tool", turning.tool},
                           {"tool_clear", turning.tool_clear}};
  }
  json["float32_error"] = real(certificate.float32_error);
  json["follows"] = follows_demonstrations(record);
  json["remarks"] = record.remarks;
  json["problem"] = {{"frame", record.problem.frame},
                     {"unsafe", record.problem.unsafe},
                     {"initial", record.problem.initial}};
  json["in_unit"] = in_unit(record);
  json["rounds"] = record.checkpoint ? record.checkpoint->round : 0;
  json["weight_hash"] = certificate.weight_hash;
  json["statement"] = certificate.statement;
  const ThreadCounts threads = thread_counts();
  json["threads"] = {{"loops", threads.loops}, {"aten", nullptr}, {"blas", nullptr}};
  if (threads.aten) json["threads"]["aten"] = *threads.aten;
  if (threads.blas) json["threads"]["blas"] = *threads.blas;
  json["run"] = path;
  return json_text(json);
}

}  // namespace s2nnds
