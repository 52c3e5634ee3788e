// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "s2nnds/core/points.h"

namespace s2nnds {

struct BranchLimits {
  std::int64_t max_boxes = 4000000;  // examined
  std::int64_t max_depth = 100;      // levels examined
  std::int64_t max_refuted = 2000;   // stop once so many boxes hold a certain violation
  // Stop once so many boxes came with and after the level of the first certain violation.
  std::int64_t max_after_refuted = 100000;
  std::int64_t max_abandoned = std::numeric_limits<std::int64_t>::max();  // the same for abandoned boxes
  std::int64_t kept_boxes = 10000;                                        // open boxes that are returned
  double max_seconds = 600.0;
};

// What is known of a box after a look at it. A refuted box holds a point where the statement certainly fails;
// an abandoned one is not worth bisecting.
enum class BoxStatus : std::uint8_t { proved, undecided, refuted, abandoned };

// Rows first, ..., first + count - 1 of boxes [N, n] and what is found out about them.
struct BoxBatch {
  const Points& lower;
  const Points& upper;
  Eigen::Index first;
  Eigen::Index count;
  std::vector<BoxStatus>& status;  // [N]
  Points& witness;                 // [N, n] where refuted
  Vector& violation;               // [N] by how much, where refuted
  // [N] how often to bisect where undecided, at least 1: more than once where the halves are hopeless as
  // well, since looking at them would cost as much as looking at what can be proved.
  std::vector<std::int32_t>& cuts;
};

// Decides the statement in question on boxes. Used by one thread only.
class BoxExaminer {
 public:
  virtual ~BoxExaminer() = default;
  virtual void examine(BoxBatch& batch) = 0;
};

struct BranchResult {
  bool proved = false;          // on all boxes
  bool stopped = false;         // by a limit: boxes that could have been bisected are open
  std::int64_t boxes = 0;       // examined
  std::int64_t open_boxes = 0;  // neither proved nor bisected further
  double open_volume = 0.0;
  Points open_lower, open_upper;  // [kept, n]: refuted boxes first
  Points witnesses;               // [kept refuted, n], the worst one first
  double worst = 0.0;             // its violation
  double seconds = 0.0;
};

struct BranchProgress {
  std::int64_t boxes = 0, waiting = 0, refuted = 0, depth = 0;
  double seconds = 0.0;
};

// Proves a statement on every box of the start [N, n] by examining boxes and bisecting the widest side of
// those that stay undecided (as often as the examiner says), level by level and in fixed batches, so that the
// result does not depend on the number of threads (unless the time limit strikes).
BranchResult branch_and_bound(Points lower, Points upper,
                              const std::function<std::unique_ptr<BoxExaminer>()>& examiner,
                              const BranchLimits& limits,
                              const std::function<void(const BranchProgress&)>& progress = nullptr);

}  // namespace s2nnds
