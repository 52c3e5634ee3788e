// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/runs/config.h"
#include "s2nnds/runs/run_record.h"

namespace s2nnds {

// A configuration made concrete: data read, normalised and split, the sets built and checked.
struct PreparedRun {
  Config config;
  RunData data;
  std::vector<Demonstration> demonstrations;  // data.normalized()
  SafetyProblem problem;

  std::vector<Demonstration> train() const { return select(demonstrations, data.split.train); }
  std::vector<Demonstration> test() const { return select(demonstrations, data.split.test); }
  std::vector<Demonstration> validation() const { return select(demonstrations, data.split.validation); }
};

// Throws Error for whatever is wrong with the data or the sets.
PreparedRun prepare(const Config& config, const std::string& data_dir);
// The sets of a stored run, from its own configuration and demonstrations.
PreparedRun prepare(const RunRecord& record, const std::string& data_dir);

// A record with all that is known before training. `text` is the configuration as the user gave it.
RunRecord new_record(const PreparedRun& setup, const std::string& text);

}  // namespace s2nnds
