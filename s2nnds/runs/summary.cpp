#include "s2nnds/runs/summary.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "s2nnds/runs/threads.h"

namespace s2nnds {

std::string summary_json(const RunRecord& record, const std::string& path) {
  using nlohmann::ordered_json;
  const auto real = [](double value) {
    return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
  };
  ordered_json json;
  json["name"] = record.name;
  json["seed"] = record.seed;
  json["guarantee"] = record.certificate.guarantee;
  json["conditions"] = ordered_json::object();
  for (const ConditionVerdict& verdict : record.certificate.conditions) {
    ordered_json& entry = json["conditions"][verdict.condition][verdict.method];
    entry = {{"verdict", verdict.verdict}, {"samples", verdict.samples}, {"violations", verdict.violations}};
    entry["worst"] = real(verdict.worst);
    if (verdict.method == "proof") {
      entry = {{"verdict", verdict.verdict},
               {"boxes", verdict.boxes},
               {"open_boxes", verdict.open_boxes},
               {"open_volume", verdict.open_volume},
               {"witness", verdict.witness}};
    }
    if (verdict.method == "conformal") {
      entry["p"] = real(verdict.quantile);
      entry["l"] = verdict.order;
      entry["epsilon"] = verdict.epsilon;
      entry["beta"] = verdict.beta;
      entry["attempt"] = verdict.attempt;
      entry["tightest_epsilon"] = verdict.tightest_epsilon;
    }
  }
  json["seconds"] = ordered_json::object();
  const ordered_json timing = ordered_json::parse(to_json(record.timing));
  for (const auto& [name, seconds] : timing.items()) {
    if (!seconds.is_null()) json["seconds"][name] = seconds;
  }
  json.update(ordered_json::parse(to_json(record.evaluation)));
  json["disturbance_margin"] = real(record.certificate.disturbance_margin);
  json["convergence_radius"] = real(record.certificate.convergence_radius);
  json["float32_error"] = real(record.certificate.float32_error);
  json["rounds"] = record.checkpoint ? record.checkpoint->round : 0;
  json["weight_hash"] = record.certificate.weight_hash;
  json["statement"] = record.certificate.statement;
  const ThreadCounts threads = thread_counts();
  json["threads"] = {{"loops", threads.loops}, {"aten", threads.aten}, {"blas", nullptr}};
  if (threads.blas) json["threads"]["blas"] = *threads.blas;
  json["run"] = path;
  return json.dump();
}

}  // namespace s2nnds
