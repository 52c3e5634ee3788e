// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "commands.h"
#include "s2nnds/sweeps/sweep_folder.h"

namespace s2nnds::program {

// Runs one trial in this process, or goes on with it where an earlier process was killed, and writes its
// result. A trial that is refused or fails has a result as well: its error. Returns the trial's own exit
// code.
int run_trial(const Sweep& sweep, const SweepFolder& folder, std::int64_t id, const CommonArguments& common);

}  // namespace s2nnds::program
