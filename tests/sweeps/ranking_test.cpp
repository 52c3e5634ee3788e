// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/ranking.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace s2nnds {
namespace {

// Three points on one configuration with two seeds: trials 0, 1 are of point 0, and so on.
Sweep three_points() {
  Sweep sweep;
  sweep.options.seeds = {0, 1};
  sweep.options.guarantee = "proved";
  sweep.options.share = 0.5;
  sweep.configs.resize(1);
  sweep.points = {{"a"}, {"b"}, {"c"}};
  return sweep;
}

TrialResult result(std::int64_t trial, const std::string& guarantee, double mse) {
  TrialResult made;
  made.trial = trial;
  made.guarantee = guarantee;
  made.metrics = {{"mse_train", mse}};
  return made;
}

std::vector<std::int64_t> order(const std::vector<PointScore>& ranking) {
  std::vector<std::int64_t> points;
  for (const PointScore& score : ranking) points.push_back(score.point);
  return points;
}

TEST(Ranking, GuaranteeFirstThenTheObjective) {
  Sweep sweep = three_points();
  std::vector<TrialResult> results = {result(0, "none", 0.001),     result(1, "conformal", 0.001),
                                      result(2, "proved", 0.4),     result(3, "none", 0.1),
                                      result(4, "invariant", 0.01), result(5, "invariant", 0.09)};
  auto ranking = rank_points(sweep, results);
  EXPECT_EQ(order(ranking), (std::vector<std::int64_t>{2, 1, 0}));
  EXPECT_NEAR(ranking[0].objective, 0.03, 1e-12);  // the geometric mean
  EXPECT_NEAR(ranking[1].objective, 0.2, 1e-12);
  EXPECT_EQ(ranking[1].share, 0.5);
  EXPECT_FALSE(ranking[2].feasible);
  sweep.options.direction = "maximize";
  EXPECT_EQ(order(rank_points(sweep, results)), (std::vector<std::int64_t>{1, 2, 0}));
}

TEST(Ranking, MotionsThatGoAnotherWayDoNotCount) {
  Sweep sweep = three_points();
  sweep.options.dtw_limit = 0.1;
  TrialResult near = result(0, "invariant", 0.1);
  near.metrics.emplace_back("dtw_train", 0.1);
  TrialResult far = near;
  far.metrics.back().second = 0.11;
  EXPECT_TRUE(counts(sweep.options, near));
  EXPECT_FALSE(counts(sweep.options, far));
  EXPECT_FALSE(counts(sweep.options, result(0, "invariant", 0.1)));  // not measured
  near.guarantee = "sampled";
  EXPECT_FALSE(counts(sweep.options, near));
  sweep.options.dtw_limit = 0.0;
  EXPECT_TRUE(counts(sweep.options, far));
}

TEST(Ranking, MissingAndFailedTrialsCountAgainstAPoint) {
  const Sweep sweep = three_points();
  TrialResult failed = result(2, "invariant", 0.001);
  failed.failed = true;
  const auto ranking = rank_points(sweep, {result(0, "proved", 0.1), result(1, "proved", 0.1), failed});
  EXPECT_EQ(order(ranking), (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(ranking[1].share, 0.0);
  EXPECT_TRUE(std::isnan(ranking[1].objective));
}

TEST(Ranking, HalvingKeepsTheBestAndAtLeastOne) {
  HalvingOptions halving;
  std::vector<PointScore> ranking(9);
  for (int i = 0; i < 9; ++i) ranking[i].point = 8 - i;
  EXPECT_EQ(promoted(halving, ranking), (std::vector<std::int64_t>{6, 7, 8}));
  halving.keep = 0.01;
  EXPECT_EQ(promoted(halving, ranking), std::vector<std::int64_t>{8});
}

TEST(Ranking, ATrialsNumberSaysWhichItIs) {
  Sweep sweep = three_points();
  sweep.configs.resize(2);
  sweep.options.halving.budgets = {1, 2};
  for (std::int64_t id = 0; id < 24; ++id) {
    const Trial trial = sweep.trial(id);
    EXPECT_EQ(((trial.rung * 3 + trial.point) * 2 + trial.config) * 2 + trial.seed, id);
  }
  EXPECT_EQ(sweep.id_of(1, 2), 20);
}

TEST(Ranking, ATrialThatIsNotCrossedIsItsPointOnOnePair) {
  Sweep sweep = three_points();
  sweep.configs.resize(2);
  sweep.options.crossed = false;
  sweep.pairs = {3, 0, 2};
  EXPECT_EQ(sweep.trials_a_rung(), 3);
  const Trial trial = sweep.trial(2);
  EXPECT_EQ(trial.point, 2);
  EXPECT_EQ(trial.config, 1);
  EXPECT_EQ(trial.seed, 0);
  EXPECT_EQ(sweep.trial(0).seed, 1);
}

}  // namespace
}  // namespace s2nnds
