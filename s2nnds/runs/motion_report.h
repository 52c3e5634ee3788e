// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/evaluation/fidelity.h"
#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

// How far the motions of f are from the training demonstrations, one each (Config::evaluation.fidelity).
std::vector<Deviation> deviations_of(const PreparedRun& setup, const NetworkWeights& f);

// Whether the record's motion counts as following all training demonstrations, as evaluate() measured it.
bool follows_demonstrations(const RunRecord& record);

// In words and in the user's unit: whether the motion follows the demonstrations, which it does not follow and why, where
// that is known; and where there is no certificate, what keeps it from one, as far as it can be seen.
std::vector<std::string> motion_remarks(const PreparedRun& setup, const RunRecord& record,
                                        const std::vector<Deviation>& deviations);

// What no certificate can have of these networks, a sentence each; empty where nothing of the kind was found.
std::vector<std::string> topology_remarks(const PreparedRun& setup, const RunRecord& record);

}  // namespace s2nnds
