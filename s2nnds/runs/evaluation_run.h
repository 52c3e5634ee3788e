// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

// Fills in errors, areas, the rollouts from the demonstrations' first points, and the grid for figures.
void evaluate(const PreparedRun& setup, RunRecord& record);

}  // namespace s2nnds
