// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "commands.h"
#include "s2nnds/sweeps/rungs.h"

namespace s2nnds::program {

// Submits what is missing of the current rung as one job array and, when rungs follow, a job that submits the
// next one. Does nothing while jobs of the sweep are in the queue. `command` is that of a sweep in this
// folder.
void submit_sweep(const Sweep& sweep, const SweepFolder& folder, const SweepState& state,
                  const std::string& slurm, std::int64_t threads, std::vector<std::string> command);

// The trials of a job array's task: places "FIRST-LAST" in the list of the rung. Without reading the results
// of all others, which would be as many reads as there are tasks times trials.
std::vector<std::int64_t> trials_of_task(const Sweep& sweep, const SweepFolder& folder, std::int64_t rung,
                                         const std::string& places);

}  // namespace s2nnds::program
