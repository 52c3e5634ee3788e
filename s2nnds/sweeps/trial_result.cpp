// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/trial_result.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/json_text.h"

namespace s2nnds {
namespace {

using nlohmann::ordered_json;

void take_numbers(const ordered_json& json, const std::string& prefix, TrialResult& result) {
  for (const auto& [name, value] : json.items()) {
    if (value.is_number() && std::isfinite(value.get<double>())) {
      result.metrics.emplace_back(prefix + name, value.get<double>());
    }
  }
}

}  // namespace

double TrialResult::metric(const std::string& name) const {
  if (name == "seconds") return seconds;
  for (const auto& [known, value] : metrics) {
    if (known == name) return value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

void take_summary(const std::string& json, TrialResult& result) {
  ordered_json summary = ordered_json::parse(json);
  result.guarantee = summary.value("guarantee", "none");
  summary.erase("seed");  // an axis
  take_numbers(summary, "", result);
  if (summary.contains("seconds")) take_numbers(summary["seconds"], "seconds_", result);
}

void write_result(const std::string& path, const TrialResult& result) {
  ordered_json json;
  json["trial"] = result.trial;
  json["status"] = result.failed ? "failed" : "done";
  json["error"] = result.error;
  json["guarantee"] = result.guarantee;
  json["seconds"] = result.seconds;
  json["metrics"] = ordered_json::object();
  for (const auto& [name, value] : result.metrics) json["metrics"][name] = value;
  write_atomic_file(path, json_text(json) + "\n", "the result");
}

std::optional<TrialResult> read_result(const std::string& path) {
  std::ifstream file(path);
  if (!file.good()) return std::nullopt;
  try {
    const ordered_json json = ordered_json::parse(file);
    TrialResult result;
    result.trial = json.at("trial");
    result.failed = json.at("status") != "done";
    result.error = json.at("error");
    result.guarantee = json.at("guarantee");
    result.seconds = json.at("seconds");
    for (const auto& [name, value] : json.at("metrics").items()) result.metrics.emplace_back(name, value);
    return result;
  } catch (const ordered_json::exception&) {
    return std::nullopt;
  }
}

}  // namespace s2nnds
