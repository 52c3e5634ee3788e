// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "s2nnds/sweeps/rungs.h"

namespace s2nnds::program {

// What a sweep runs its trials with on this machine, each in a process of its own.
struct LocalMeans {
  std::string program;  // absolute path of s2nnds
  std::string data;     // absolute path of the data files' folder; may be empty
  std::int64_t threads = 1;
  int jobs = 1;  // trials at once
};

// Runs the trials, of which some in `before` have ended already, and says on stderr how far it is. A trial
// whose process is killed goes on from its last round; one that leaves no result fails. Returns whether all
// came to their end, rather than being interrupted.
bool run_trials(const Sweep& sweep, const SweepFolder& folder, const LocalMeans& means,
                const std::vector<TrialResult>& before, const std::vector<std::int64_t>& trials);

// Runs what is missing of all rungs, one after another; nothing when it was interrupted. Throws Error when
// another process runs a sweep in this folder.
std::optional<SweepState> run_sweep(const Sweep& sweep, const SweepFolder& folder, const LocalMeans& means);

// Forgets the results of trials that failed, so that they are run again.
void forget_failed(const SweepFolder& folder, const SweepState& state);

}  // namespace s2nnds::program
