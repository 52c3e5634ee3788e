// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "s2nnds/training/history.h"
#include "s2nnds/training/loss_part.h"
#include "s2nnds/training/trainer_options.h"

namespace s2nnds {

// What the next round of training does.
struct RoundPlan {
  bool finished = false;         // there is no next round; the rest means nothing then
  Stage stage = Stage::search;   // what the round is for
  std::int64_t refining = 0;     // place in a row of rounds that refine, from 1; 0: does not refine
  bool starts_anew = false;      // from the warm start's f, V and B drawn anew, rates at their full height
  bool labels_rollouts = false;  // fresh points are labelled by their rollouts first
  bool backtracks = false;       // motions that violate a condition are followed back first
  Trains trains = {};            // the networks that do not stay as they are
  bool undone_unless_clean = false;  // networks that do not end clean give way to those from before
  double largest_deviation =
      1.0;                   // as do those whose motions are farther from the demonstrations, as a share
  double may_lose = 1.0;     // and those whose {B <= 0} has lost more of its volume, as a share
  std::int64_t repairs = 0;  // times that V and B are trained on what was found, before it is judged
  double rate = 1.0;         // factor of all rates
  LossOptions loss = {};     // with the weights of this round
};

// The schedule of training, from the rounds so far (history[k].round == k, the warm start first) and the
// options alone:
// - search, until a round of at least min_rounds ends clean and its motions follow the demonstrations (after
//   six clean ones whose motions do not, without that), or `rounds` have ended. Rates fall from round to round.
//   It starts anew every rate_period rounds, up to five later where few counterexamples are left, with relaxed
//   weights; after four rounds in a row that no certificate can have; and after every third clean round of
//   another motion, which all give more weight to the demonstrations. Every second start does not push f outwards at the obstacle. A round after one that was
//   nearly clean refines. Where a clean round's motions follow the demonstrations nearly, up to three rounds
//   approach them as those of the next stage do.
// - imitation_finetune: all three networks are trained with more weight on the demonstrations, so that f
//   comes nearer to what it would be without conditions; until its error is 0.7 of the warm start's, or four rounds
//   were kept.
// - enlarge: B alone is trained, and rollout_safety weighs more, so that the safe set grows. It may lose 1 % in the
//   first round, nothing in the last: on the way to a larger one it is often a little smaller.
// The last two keep only rounds that end clean, and each one that does not makes the next one of its stage
// more careful. Throws Error if the history is empty.
RoundPlan plan(const std::vector<RoundSummary>& history, const TrainerOptions& options);

// What follows a round that ended nearly clean, as `row` says, as often as its `repairs` say: of V and B those whose
// conditions are violated are trained for half as many steps on what was found, f is not. What holds of the other stays
// true.
RoundPlan repair_plan(const RoundPlan& round, const RoundSummary& row, const TrainerOptions& options);

// Whether few enough counterexamples are left for a repair.
bool is_repairable(const RoundSummary& row);

// Whether the search has ended with a clean round. All later ones keep it so.
bool has_clean_round(const std::vector<RoundSummary>& history, const TrainerOptions& options);

}  // namespace s2nnds
