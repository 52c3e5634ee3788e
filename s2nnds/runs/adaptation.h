// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "s2nnds/runs/prepared_run.h"
#include "s2nnds/training/history.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

// How a certificate for a changed scene was come by.
enum class Adaptation : std::uint8_t {
  held,     // the old networks are certified in the new scene as they are
  adapted,  // trained on from the old networks
  anew,     // trained from scratch, since that did not end in time
  failed    // no certificate
};
// The name of the enumerator.
std::string_view to_string(Adaptation adaptation);

struct AdaptationResult {
  RunRecord record;  // of the new scene, proved; its safe area is not measured
  Adaptation outcome = Adaptation::failed;
  double seconds = 0.0;  // of all that adapt() did
  // Normalised, seen from the goal: the largest distance of a motion from a training demonstration's start from the old
  // run's, matched in order along both.
  double motion_change = 0.0;
};

// What adapt() calls as it goes.
struct AdaptationHooks {
  std::function<void(const RoundSummary&)> progress;  // after every round; may be empty
  std::function<bool()> cancelled;                    // true ends it after the round; may be empty
};

// From a run with networks to a certified run in a changed scene. `settings` ("problem.unsafe.center=[0.1, 0.2]") change
// keys of its configuration: any below problem; data.goal, a point [n] in the data's frame, to which the motion moves as it is, while
// sets in the data's frame stay where they are; data.files, use, test and validation, after which demonstrations are read again.
// The frame's scales and the seed stay those of the run. First the old networks are proved in the new scene; then B alone
// is trained (where the old motion follows the demonstrations), then all three, at most ten rounds; then from scratch.
// `data_dir` has files that the settings name. The motion stays what it was as long as B alone trains. Throws Error for
// settings of other keys, for scenes that make_problem refuses, and runs without a training split.
AdaptationResult adapt(const RunRecord& old, const std::vector<std::string>& settings,
                       const std::string& data_dir, const AdaptationHooks& hooks = {});

}  // namespace s2nnds
