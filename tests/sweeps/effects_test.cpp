#include "s2nnds/sweeps/effects.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

// 120 points on one pair each of three problems and two seeds: MSE = c_problem a^0.1 1.2^[letter = "z"]
// e^noise.
struct Study {
  Sweep sweep;
  std::vector<TrialResult> results;
};

Study study(double noise) {
  Study made;
  Sweep& sweep = made.sweep;
  sweep.options.design = "random";
  sweep.options.points = 120;
  sweep.options.seeds = {0, 1};
  sweep.options.guarantee = "proved";
  sweep.configs.resize(3);
  sweep.axes = {{.key = "a", .low = 0.01, .high = 1.0, .logarithmic = true},
                {.key = "b", .values = {"x", "y", "z"}}};
  sweep.points = make_design(sweep.options, sweep.axes);
  sweep.pairs = pairs_in_turn(120, 6, 0);
  RandomStream random(7, "effects_test");
  for (std::int64_t id = 0; id < 120; ++id) {
    const Trial trial = sweep.trial(id);
    const DesignPoint& point = sweep.points[trial.point];
    const double mse = std::pow(10.0, trial.config - 3.0) * std::pow(std::stod(point[0]), 0.1) *
                       (point[1] == "z" ? 1.2 : 1.0) * std::exp(noise * random.normal());
    TrialResult result;
    result.trial = id;
    result.guarantee = "proved";
    result.seconds = 10.0;
    result.metrics = {{"mse_train", mse}, {"safe_area_ratio", 0.9 - (point[1] == "y" ? 0.05 : 0.0)}};
    made.results.push_back(result);
  }
  return made;
}

TEST(Effects, AreThoseOfTheModelWhereItHolds) {
  const Study made = study(0.0);
  const EffectTable table = estimate_effects(made.sweep, made.results);
  ASSERT_EQ(table.figures.size(), 4U);
  EXPECT_EQ(table.figures[0].name, "mse_train");
  EXPECT_TRUE(table.figures[0].factor);
  EXPECT_EQ(table.figures[0].trials, 120);
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[0].from, "0.01");
  EXPECT_EQ(table.rows[0].to, "1.0");
  EXPECT_NEAR(table.rows[0].on[0].change, std::pow(100.0, 0.1), 1e-4);  // values are rounded to six digits
  EXPECT_NEAR(table.rows[1].on[0].change, 1.0, 1e-4);
  EXPECT_NEAR(table.rows[2].on[0].change, 1.2, 1e-4);
  EXPECT_LT(table.rows[2].on[0].error, 1e-4);
  EXPECT_EQ(table.figures[2].name, "safe_area_ratio");
  EXPECT_FALSE(table.figures[2].factor);
  EXPECT_NEAR(table.rows[1].on[2].change, -0.05, 1e-9);
}

// Noise of .1 in the logarithm: a slope over its range has the standard error .1 sqrt(12 / 120) = .032, the
// difference of two thirds of the trials .1 sqrt(2 / 40) = .022; four of them fail by chance in 1e-4.
TEST(Effects, ErrorsSayHowFarTheyMayBeOff) {
  const Study made = study(0.1);
  const EffectTable table = estimate_effects(made.sweep, made.results);
  const double true_logarithm[] = {0.1 * std::log(100.0), 0.0, std::log(1.2)};
  const double expected[] = {0.0316, 0.0224, 0.0224};
  for (std::size_t k = 0; k < 3; ++k) {
    const Effect& effect = table.rows[k].on[0];
    EXPECT_NEAR(effect.error / effect.change, expected[k], 0.3 * expected[k]) << k;
    EXPECT_NEAR(std::log(effect.change), true_logarithm[k], 4.0 * expected[k]) << k;
  }
}

TEST(Effects, OnlyTrialsThatCountAreMeasuredAllOfThemAreCounted) {
  Study made = study(0.0);
  for (TrialResult& result : made.results) {
    const bool misses = made.sweep.points[made.sweep.trial(result.trial).point][1] == "x";
    if (!misses) continue;
    result.guarantee = "none";
    result.metrics[0].second = 1e6;
  }
  made.results[0].failed = true;
  const EffectTable table = estimate_effects(made.sweep, made.results);
  EXPECT_EQ(table.figures[1].name, "counts");
  EXPECT_EQ(table.figures[1].trials, 120);
  EXPECT_NEAR(table.rows[1].on[1].change, 1.0, 0.05);
  EXPECT_LT(table.figures[0].trials, 100);
  EXPECT_FALSE(table.figures[0].told);  // no trial with "x" is left to compare with
  EXPECT_TRUE(std::isnan(table.rows[1].on[0].change));
}

TEST(Effects, AreNotToldOfWhatIsTheSameInAllTrials) {
  const Study made = study(0.0);
  const EffectTable table = estimate_effects(made.sweep, made.results);
  EXPECT_FALSE(table.figures[1].told);  // all count
  EXPECT_EQ(table.figures[3].name, "seconds");
  EXPECT_FALSE(table.figures[3].told);
}

TEST(Effects, AreNotToldByFewerTrialsThanThereAreUnknowns) {
  Study made = study(0.0);
  made.results.resize(6);
  for (const EffectFigure& figure : estimate_effects(made.sweep, made.results).figures)
    EXPECT_FALSE(figure.told);
}

}  // namespace
}  // namespace s2nnds
