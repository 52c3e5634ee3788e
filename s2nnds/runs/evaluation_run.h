// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

// Fills in the record's `evaluation`, `rollouts` (from the first points of training and test demonstrations),
// `grid` (n <= 3) and `timing.evaluation`, for its networks.
void evaluate(const PreparedRun& setup, RunRecord& record);

// The same without the safe areas, which take most of the time and stay unmeasured.
void evaluate_motion(const PreparedRun& setup, RunRecord& record);

}  // namespace s2nnds
