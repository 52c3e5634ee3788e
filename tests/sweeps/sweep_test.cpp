// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/sweep.h"

#include <gtest/gtest.h>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

const std::string kConfigs = S2NNDS_SOURCE_DIR "/experiments/configs";

SweepOptions listed() {
  SweepOptions options;
  options.name = "listed";
  options.design = "list";
  options.configs = {"lasa/Sine.toml", "abc_ds/Sine.toml"};
  options.set = {"training.steps=7"};
  options.trials = {
      {.config = "Sine", .seed = 4},
      {.config = "Sine_abc_ds", .profile = "imitation", .test = {1, 5}, .set = {"training.steps=9"}}};
  return options;
}

std::string message_of(const SweepOptions& options) {
  try {
    parse_sweep(to_toml(options), "made.toml", kConfigs);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Sweep, AListHoldsItsTrialsAndNoOthers) {
  const Sweep sweep = parse_sweep(to_toml(listed()), "made.toml", kConfigs);
  ASSERT_EQ(sweep.trials_a_rung(), 2);
  EXPECT_EQ(sweep.label(sweep.trial(0)), "Sine-seed4");
  EXPECT_EQ(sweep.settings(sweep.trial(0)), (std::vector<std::string>{"training.steps=7", "seed=4"}));
  const Trial trial = sweep.trial(1);
  EXPECT_EQ(trial.config, 1);
  EXPECT_EQ(trial.profile, "imitation");
  EXPECT_EQ(sweep.label(trial), "Sine_abc_ds-test1_5-seed0-imitation");
  EXPECT_EQ(sweep.settings(trial),
            (std::vector<std::string>{"profile=\"imitation\"", "data.test=[1, 5]", "training.steps=9",
                                      "training.steps=7", "seed=0"}));
}

TEST(Sweep, SplitsBetaOverItsConformalTrials) {
  SweepOptions options = listed();
  options.trials[0].set = {"verification.method=\"conformal\"", "verification.conformal.beta=0.01"};
  options.trials[1].set = {"verification.method=\"proof\""};
  Sweep sweep = parse_sweep(to_toml(options), "made.toml", kConfigs);
  EXPECT_TRUE(sweep.is_conformal);
  EXPECT_EQ(sweep.settings(sweep.trial(0)).back(), "verification.conformal.beta=0.005");
  EXPECT_EQ(sweep.settings(sweep.trial(1)).back(), "seed=0");  // a proof has no beta
  options.trials[0].set[0] = "verification.method=\"sampled\"";
  sweep = parse_sweep(to_toml(options), "made.toml", kConfigs);
  EXPECT_FALSE(sweep.is_conformal);
  EXPECT_EQ(sweep.settings(sweep.trial(0)).back(), "seed=4");
  // All budgets count; a value of an axis suffices.
  options = {};
  options.configs = {"lasa/Sine.toml"};
  options.seeds = {0, 1};
  options.halving.budgets = {8, 16};
  sweep = parse_sweep(to_toml(options) + "\n[axes]\n\"verification.method\" = [\"proof\", \"conformal\"]\n",
                      "made.toml", kConfigs);
  EXPECT_TRUE(sweep.is_conformal);
  ASSERT_EQ(sweep.trials(), 8);
  int split = 0;
  for (std::int64_t id = 0; id < 8; ++id)
    split += sweep.settings(sweep.trial(id)).back() == "verification.conformal.beta=1.25e-05" ? 1 : 0;
  EXPECT_EQ(split, 4);
}

TEST(Sweep, ABadListIsRefused) {
  SweepOptions options = listed();
  options.trials[1].config = "Worm";
  EXPECT_EQ(message_of(options), "listed: trials: found no configuration of the name \"Worm\"");
  options = listed();
  options.trials[1].set = {"training.stepz=3"};
  EXPECT_NE(message_of(options).find("made.toml: trial 1: "), std::string::npos);
  options.trials.clear();
  EXPECT_EQ(message_of(options), "made.toml: trials: expected at least one for the design list, found 0");
  options = listed();
  options.design = "grid";
  EXPECT_EQ(message_of(options), "made.toml: trials: expected none for the design grid, found 2");
}

}  // namespace
}  // namespace s2nnds
