// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "s2nnds/runs/prepared_run.h"
#include "s2nnds/training/trainer.h"

namespace s2nnds {

// What train() calls as it goes; an empty function is not called.
struct TrainingHooks {
  std::function<void(const RoundSummary&)> progress;  // after the warm start and every round
  std::function<void(const RunRecord&)> checkpoint;   // the record so far, at the same moments
  std::function<bool()> cancelled;                    // asked after every round; true stops
  bool until_certified =
      false;  // stop at the first certificate; train() goes on from there when called again
};

// Trains from where the record's checkpoint stands (from the start if it has none) and fills in networks,
// history, checkpoint and timing. The certificate is reset: it spoke of other weights.
TrainerSummary train(const PreparedRun& setup, RunRecord& record, const TrainingHooks& hooks);

}  // namespace s2nnds
