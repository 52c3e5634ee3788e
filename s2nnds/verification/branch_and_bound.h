// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/verification/bisection_tree.h"

namespace s2nnds {

// When branch_and_bound stops before all is decided. The limits on boxes are looked at before each level.
struct BranchLimits {
  std::int64_t max_boxes = 4000000;  // most boxes examined, >= 1; a level that would pass it is left open
  std::int64_t max_depth = 100;      // deepest level examined, counted from 0
  std::int64_t max_refuted = 2000;   // stop once so many boxes hold a certain violation
  // Stop once more boxes than this were examined from the level of the first certain violation on.
  std::int64_t max_after_refuted = 100000;
  // Stop once so many boxes were abandoned.
  std::int64_t max_abandoned = std::numeric_limits<std::int64_t>::max();
  // Stop once the boxes of a level, those that it is to be cut into and all open ones would take more bytes. The limit is
  // far beyond what proofs in two and three dimensions take, and leaves room for the rest of a program below 4 GiB.
  double max_bytes = 2147483648.0;
  // Stop once more boxes than this seem to be needed in all, by the examiners' cuts: then nobody waits for what cannot end.
  double max_expected = std::numeric_limits<double>::infinity();
  std::int64_t kept_boxes = 10000;  // open boxes that are returned, at most
  double max_seconds = 600.0;       // wall clock, > 0; boxes not examined by then are left open
  bool keep_tree = false;           // whether BranchResult::tree is filled
};

// What is known of a box after a look at it.
enum class BoxStatus : std::uint8_t {
  proved,     // the statement holds on the whole box
  excluded,   // it asks nothing of the box
  undecided,  // to be bisected
  refuted,    // holds a point where the statement certainly fails
  // Not decided, and not worth bisecting.
  abandoned
};

// So often at most is a box bisected before the next look at its parts.
inline constexpr std::int32_t most_cuts = 6;

// Rows first, ..., first + count - 1 of boxes [N, n] and what is found out about them.
struct BoxBatch {
  const Points& lower;             // [N, n] lower corners, normalised
  const Points& upper;             // [N, n] upper corners, normalised
  Eigen::Index first;              // row of the first box to examine, from 0
  Eigen::Index count;              // boxes to examine, >= 1
  std::vector<BoxStatus>& status;  // [N]
  Points& witness;                 // [N, n] where refuted
  Vector& violation;               // [N] by how much, where refuted
  // [N] a number that a box leaves to its parts: what was left to it, +infinity at the start, unless changed.
  Vector& carried;
  // [N] how often to bisect where undecided until it may be decided, as far as can be told; at least 1. So many times,
  // most_cuts at most, it is bisected before the next look: looking at hopeless halves would cost as much as looking at
  // others. All of a level's are bisected more often where the next one would have 8 boxes or fewer: up to 16 take as long.
  std::vector<std::int32_t>& cuts;
};

// Decides the statement in question on boxes. Used by one thread only.
class BoxExaminer {
 public:
  virtual ~BoxExaminer() = default;
  // Fills in status, witness, violation, carried and cuts of the batch's rows, and of no others.
  virtual void examine(BoxBatch& batch) = 0;
};

// What branch_and_bound found out.
struct BranchResult {
  bool proved = false;          // on all boxes
  bool stopped = false;         // by a limit: boxes that could have been bisected are open
  std::int64_t boxes = 0;       // examined
  double expected = 0.0;        // > 0: stopped because so many boxes seem to be needed
  std::int64_t open_boxes = 0;  // neither proved nor bisected further
  double open_volume = 0.0;     // of all open boxes together, normalised length^n
  Points open_lower,            // [kept, n] lower corners of open boxes, refuted ones first, normalised
      open_upper;               // [kept, n] their upper corners
  Points witnesses;             // [kept refuted, n], the worst one first
  double worst = 0.0;           // its violation
  BisectionTree tree;           // of the start's boxes, where all was proved and BranchLimits asked for it
  double seconds = 0.0;         // wall clock
};

// How far branch_and_bound has come, after each level.
struct BranchProgress {
  std::int64_t boxes = 0,  // examined so far
      waiting = 0,         // undecided boxes of this level, to be bisected
      refuted = 0,         // boxes with a certain violation so far
      depth = 0;           // the level, from 0
  double seconds = 0.0;    // wall clock since the start
};

// Proves a statement on every box of the start [N, n] by examining boxes and bisecting the widest side of
// those that stay undecided (as often as the examiner says, most_cuts times at most), level by level and in fixed batches, so that the
// result does not depend on the number of threads (unless the time limit strikes). `examiner` makes one
// examiner for each thread; `progress` is called after each level. Throws Error on boxes that are not finite,
// or when `lower` and `upper` differ in shape.
BranchResult branch_and_bound(Points lower, Points upper,
                              const std::function<std::unique_ptr<BoxExaminer>()>& examiner,
                              const BranchLimits& limits,
                              const std::function<void(const BranchProgress&)>& progress = nullptr);

}  // namespace s2nnds
