// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace s2nnds {

// What a trial came to, a small file of its own: many trials may end at once, on many nodes, and no server is
// needed.
struct TrialResult {
  std::int64_t trial = 0;          // Trial::id
  bool failed = false;             // it ended with an error, or was killed too often
  std::string error;               // one line, when it failed
  std::string guarantee = "none";  // that the run reached: to_string(Guarantee)
  double seconds = 0.0;            // of the process that ended it, not of killed ones before
  // (name, value) of the run's summary; those that were not measured left out.
  std::vector<std::pair<std::string, double>> metrics;

  // The metric's value; NaN when there is none of this name.
  double metric(const std::string& name) const;
};

// Takes guarantee and metrics from a run's summary (one JSON object): its numbers, those of `seconds` as
// seconds_NAME.
void take_summary(const std::string& json, TrialResult& result);

// Replaces the file whole. Throws Error when it cannot be written.
void write_result(const std::string& path, const TrialResult& result);

// Nothing when there is no such file, or half of one after a crash of the machine: the trial is run again.
std::optional<TrialResult> read_result(const std::string& path);

}  // namespace s2nnds
