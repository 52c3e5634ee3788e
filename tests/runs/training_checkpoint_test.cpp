// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/training_checkpoint.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// What later rounds are planned by comes back, else a resumed run would train otherwise than an unbroken one.
TEST(TrainingCheckpoint, KeepsWhatEachRoundFound) {
  TrainerState state;
  state.pools = {Points::Constant(2, 2, 0.5), Points(0, 2), Points(0, 2)};
  state.history.resize(3);
  for (std::size_t k = 0; k < state.history.size(); ++k) {
    RoundSummary& row = state.history[k];
    row.round = static_cast<std::int64_t>(k);
    row.loss_terms.fill(0.5 * row.round);
    row.counts.fill(7 * row.round);
    row.found_by_sampling = 5 * row.round;
    row.volume = 0.25 * static_cast<double>(k);
    row.stage = k == 2 ? Stage::enlarge : Stage::imitation_finetune;
  }
  RunRecord record;
  record.data.dimension = 2;
  store_trainer_state(state, record);
  const TrainerState back = to_trainer_state(record);
  ASSERT_EQ(back.history.size(), 3U);
  for (std::size_t k = 0; k < back.history.size(); ++k) {
    EXPECT_EQ(back.history[k].loss_terms, state.history[k].loss_terms);
    EXPECT_EQ(back.history[k].counts, state.history[k].counts);
    EXPECT_EQ(back.history[k].found_by_sampling, state.history[k].found_by_sampling);
    EXPECT_EQ(back.history[k].volume, state.history[k].volume);
    EXPECT_EQ(back.history[k].stage, state.history[k].stage);
  }
  EXPECT_EQ(back.pools.workspace, state.pools.workspace);
}

// Run files of earlier programs do not tell the volume of the safe set.
TEST(TrainingCheckpoint, VolumeMayBeMissing) {
  TrainerState state;
  state.pools = {Points(0, 2), Points(0, 2), Points(0, 2)};
  state.history.resize(1);
  RunRecord record;
  record.data.dimension = 2;
  store_trainer_state(state, record);
  std::erase_if(record.history, [](const auto& column) { return column.first == "volume"; });
  EXPECT_EQ(to_trainer_state(record).history.at(0).volume, 0.0);
  record.history.pop_back();
  EXPECT_THROW(to_trainer_state(record), Error);
}

}  // namespace
}  // namespace s2nnds
