// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/runs/run_record.h"

namespace s2nnds {

// One JSON object: name, seed, guarantee, conditions{}, seconds{}, the figures of EvaluationSummary, run, and
// more, in normalised units; in_unit{} has goal, workspace and figures in the data's unit and frame, problem{} the
// sets as the configuration wrote them. Numbers that were not measured are null. `path` is where the run is stored.
std::string summary_json(const RunRecord& record, const std::string& path);

}  // namespace s2nnds
