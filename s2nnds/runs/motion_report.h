// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/evaluation/fidelity.h"
#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

// How far the motions of f are from the training demonstrations, one each (Config::evaluation.fidelity).
std::vector<Deviation> deviations_of(const PreparedRun& setup, const StateFunction& f);

// The same from 32 starts that cover X0 (spread_starts), which differ from `draw` to draw; empty where X0 has
// no volume.
std::vector<Deviation> start_deviations_of(const PreparedRun& setup, const Dynamics& f,
                                           std::int64_t draw = 0);
// The largest mean / limit of both: at most 1 where the motion follows the demonstrations from all these
// starts.
double worst_deviation(const PreparedRun& setup, const Dynamics& f, std::int64_t draw = 0);
// What the motions that stray from what they should be, from the demonstrations' starts and from X0, are
// corrected to.
VelocityTargets corrections_of(const PreparedRun& setup, const Dynamics& f, std::int64_t draw);

// Whether the record's motion counts as following the training demonstrations, from each of them and from X0,
// as evaluate() measured it.
bool follows_demonstrations(const RunRecord& record);

// In words and in the user's unit: whether the motion follows the demonstrations, which it does not follow
// and why, where that is known; and where there is no certificate, what keeps it from one, as far as it can
// be seen.
std::vector<std::string> motion_remarks(const PreparedRun& setup, const RunRecord& record,
                                        const std::vector<Deviation>& from_shown,
                                        const std::vector<Deviation>& from_initial);

// What no certificate can have of these networks, a sentence each; empty where nothing of the kind was found.
std::vector<std::string> topology_remarks(const PreparedRun& setup, const RunRecord& record);

}  // namespace s2nnds
