// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/runs/run_record.h"
#include "s2nnds/training/trainer.h"

namespace s2nnds {

// The trainer's state as a run file holds it: networks, counterexample pools (checkpoint) and rounds
// (history).
void store_trainer_state(const TrainerState& state, RunRecord& record);

// Throws Error naming the column or point set that is missing or does not fit.
TrainerState to_trainer_state(const RunRecord& record);

}  // namespace s2nnds
