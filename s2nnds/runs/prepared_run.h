// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/runs/config.h"
#include "s2nnds/runs/run_record.h"

namespace s2nnds {

// A configuration made concrete: data read, normalised and split, the sets built and checked.
struct PreparedRun {
  Config config;                              // that all else was made from
  RunData data;                               // demonstrations as read, with frame and split
  std::vector<Demonstration> demonstrations;  // data.normalized()
  SafetyProblem problem;                      // X, X0 and Xu, normalised
  RegionFiles files;                          // that the regions of `problem` were made from

  // Normalised demonstrations for training.
  std::vector<Demonstration> train() const { return select(demonstrations, data.split.train); }
  // Normalised demonstrations for testing, perhaps none.
  std::vector<Demonstration> test() const { return select(demonstrations, data.split.test); }
  // Normalised demonstrations for choosing among runs, perhaps none.
  std::vector<Demonstration> validation() const { return select(demonstrations, data.split.validation); }
};

// Reads the data that the configuration names, from files below `data_dir`, and builds the sets. Throws Error
// for whatever is wrong with the data or the sets.
PreparedRun prepare(const Config& config, const std::string& data_dir, const ReadingProgress& progress = {});
// The same from demonstrations that were read already, with the files that the regions name.
PreparedRun prepare(const Config& config, DemonstrationSet as_read, RegionFiles files);
PreparedRun prepare(Config config, RunData data, RegionFiles files);
// The same for a stored run, from its own configuration, demonstrations and files.
PreparedRun prepare(const RunRecord& record);

// A record with all that is known before training. `text` is the configuration as the user gave it.
RunRecord new_record(const PreparedRun& setup, const std::string& text);

}  // namespace s2nnds
