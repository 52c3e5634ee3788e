// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/plan.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cstdint>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// How a round ended.
struct Round {
  std::int64_t found = 0;         // counterexamples of any source
  std::int64_t by_sampling = -1;  // of these, by random search; -1: all
  Stage stage = Stage::search;
  double deviation = 0.0;
  std::int64_t islands = 0;
};

constexpr Round kBad{5000}, kClean{0}, kFew{199}, kFewer{50}, kHidden{900, 0};
constexpr Round kOther{0, -1, Stage::search, 2.0}, kNearly{0, -1, Stage::search, 1.2},
    kNearer{0, -1, Stage::search, 1.1}, kIsland{5000, -1, Stage::search, 0.0, 1};
constexpr Round kFinetuned{0, -1, Stage::imitation_finetune}, kNotFinetuned{7, -1, Stage::imitation_finetune};
constexpr Round kEnlarged{0, -1, Stage::enlarge}, kNotEnlarged{7, -1, Stage::enlarge};

using Rounds = std::vector<Round>;

Rounds operator*(std::size_t count, const Round& round) { return Rounds(count, round); }
Rounds operator+(Rounds first, const Rounds& then) {
  first.insert(first.end(), then.begin(), then.end());
  return first;
}

std::vector<RoundSummary> history_of(const Rounds& rounds) {
  std::vector<RoundSummary> history(1);  // the warm start
  for (const Round& round : rounds) {
    RoundSummary row;
    row.round = static_cast<std::int64_t>(history.size());
    row.counts.back() = round.found;
    row.found_by_sampling = round.by_sampling < 0 ? round.found : round.by_sampling;
    row.stage = round.stage;
    row.deviation = round.deviation;
    row.islands = round.islands;
    history.push_back(row);
  }
  return history;
}

// In words: the weights are told as factors of those of the options, where they differ.
std::string told(const RoundPlan& next, const TrainerOptions& options) {
  if (next.finished) return "finished";
  constexpr const char* stages[] = {"search", "imitation_finetune", "enlarge"};
  std::string text = stages[static_cast<std::size_t>(next.stage)];
  if (next.refining > 0) text += fmt::format(", refines ({})", next.refining);
  if (next.starts_anew) text += ", starts anew";
  if (next.labels_rollouts) text += ", labels";
  if (next.backtracks) text += ", backtracks";
  if (!next.trains.f) text += ", only B";
  if (next.undone_unless_clean) text += ", may be undone";
  if (next.may_lose < 1.0) text += fmt::format(", may lose {:.3g}", next.may_lose);
  const bool usual = next.stage == Stage::search && options.refine && next.trains.f;
  if (next.repairs != (usual ? 2 : 0)) text += fmt::format(", {} repairs", next.repairs);
  text += fmt::format("; rate {:.4g}", next.rate);
  for (const LossTerm term : all_loss_terms) {
    const double before = options.loss.weight[term], now = next.loss.weight[term];
    if (now != before) text += fmt::format(", {} {:.4g}", to_string(term), now / before);
  }
  return text;
}

struct Case {
  const char* about;
  Rounds rounds;
  std::string plan;
};

void expect_plans(const TrainerOptions& options, const std::vector<Case>& cases) {
  for (const Case& each : cases)
    EXPECT_EQ(told(plan(history_of(each.rounds), options), options), each.plan) << each.about;
}

const Rounds kFirstClean = 4 * kBad + Rounds{kClean};
const std::string kSearch = "search, labels, backtracks; rate ",
                  kAnew = "search, starts anew, labels, backtracks; rate 1",
                  kFinetune = "imitation_finetune, labels, may be undone, 2 repairs; rate 0.3";

// May lose a share of {B <= 0}.
std::string enlarge(double loss, const std::string& rollouts) {
  return fmt::format(
      "enlarge, labels, only B, may be undone, may lose {:.3g}, 1 repairs; rate 0.5, imitation 0, lyapunov "
      "0, "
      "barrier_sets 2, barrier_decrease 2{}, obstacle_normal 0",
      loss, rollouts);
}

TrainerOptions not_before(std::int64_t round) {
  TrainerOptions options;
  options.min_rounds = round;
  return options;
}

TEST(Plan, SearchesAtFallingRates) {
  expect_plans(not_before(5), {{"warm start", {}, kSearch + "1"},
                               {"one round", {kBad}, kSearch + "0.9"},
                               {"clean too early", {kBad, kClean}, kSearch + "0.81"},
                               {"nearly clean too early", {kBad, kBad, kFew}, kSearch + "0.729"}});
  TrainerOptions options;
  options.rate_period = 0;
  expect_plans(options, {{"never anew", 20 * kBad, kSearch + "0.1216"},
                         {"the least rate", 35 * kBad, kSearch + "0.05"}});
}

TEST(Plan, StartsAnewWithRelaxedWeights) {
  const std::string once =
      ", imitation 0.5, rollout_safety 0.3, obstacle_normal 0";  // every second one does not push
  expect_plans({},
               {{"before", 9 * kBad, kSearch + "0.3874"},
                {"once", 10 * kBad, kAnew + once},
                {"it lasts", 11 * kBad, kSearch + "0.9" + once},
                {"twice", 20 * kBad, kAnew + ", imitation 0.25, rollout_safety 0.09, obstacle_normal 0.09"},
                {"nearly clean", 9 * kBad + Rounds{kFew}, kAnew + once}});
  TrainerOptions options;
  options.rate_period = 2;
  options.relax_weights = false;
  expect_plans(options, {{"weights stay", 4 * kBad, kAnew}});
  options.barrier_rounds = 2;
  const std::string barrier = "search, labels, backtracks, only B; rate ",
                    nothing_else = ", imitation 0, lyapunov 0, obstacle_normal 0";
  expect_plans(options, {{"B alone at first", {}, barrier + "1" + nothing_else},
                         {"and once more", {kBad}, barrier + "0.9" + nothing_else},
                         {"then all", 2 * kBad, kAnew + ", obstacle_normal 0"}});
}

TEST(Plan, DoesNotStartAnewForItsAgeWhereLittleIsLeft) {
  const auto starts_anew = [](const Rounds& rounds) { return plan(history_of(rounds), {}).starts_anew; };
  EXPECT_FALSE(starts_anew(9 * kBad + Rounds{kFewer}));
  EXPECT_FALSE(starts_anew(9 * kBad + 5 * kFewer));
  EXPECT_TRUE(starts_anew(9 * kBad + 6 * kFewer));
  EXPECT_TRUE(starts_anew(9 * kBad + Rounds{kFewer, kBad}));
}

TEST(Plan, StartsAnewWhereNoCertificateCanExist) {
  const std::string pushes_not = ", obstacle_normal 0";
  expect_plans({},
               {{"three in a row", 3 * kIsland, kSearch + "0.729"},
                {"four in a row", 4 * kIsland, kAnew + pushes_not},
                {"with one between", 3 * kIsland + Rounds{kBad, kIsland}, kSearch + "0.5905"},
                {"once more", 8 * kIsland, kAnew},
                {"counted from the last start", 4 * kIsland + 9 * kBad, kSearch + "0.3874" + pushes_not}});
}

TEST(Plan, DoesNotTakeACertificateOfAnotherMotion) {
  expect_plans({}, {{"once", {kOther}, kSearch + "0.9, imitation 2"},
                    {"it lasts", {kOther, kBad}, kSearch + "0.81, imitation 2"},
                    {"twice", 2 * kOther, kSearch + "0.81, imitation 4"},
                    {"three times", 3 * kOther, kAnew + ", imitation 4, obstacle_normal 0"},
                    {"it is taken at last, as it is", 6 * kOther, "finished"}});
  EXPECT_FALSE(has_clean_round(history_of(5 * kOther), {}));
  EXPECT_TRUE(has_clean_round(history_of({kOther, kClean}), {}));
}

TEST(Plan, ApproachesTheDemonstrationsWhereACertifiedMotionFollowsThemNearly) {
  const auto after = [](const Rounds& rounds) { return plan(history_of(rounds), {}); };
  const auto weight = [&](const Rounds& rounds) {
    return after(rounds).loss.weight[LossTerm::imitation] / LossOptions{}.weight[LossTerm::imitation];
  };
  const RoundPlan first = after({kNearly});
  EXPECT_EQ(first.stage, Stage::search);
  EXPECT_TRUE(first.undone_unless_clean);
  EXPECT_EQ(first.largest_deviation, 1.2);
  EXPECT_EQ(weight({kNearly}), 2.5);
  EXPECT_EQ(after({kNearly, kNearer}).largest_deviation, 1.1);
  EXPECT_EQ(after({kNearly, kOther}).largest_deviation, 1.2);  // which was undone
  EXPECT_EQ(weight({kNearly, kFew}), 1.0);
  EXPECT_FALSE(after({kNearly, kFew, kFew, kFew}).undone_unless_clean);
  EXPECT_EQ(weight({kNearly, kFew, kFew, kFew}), 2.0);  // as after any certificate of another motion
  EXPECT_EQ(after({kNearly, kClean}).stage, Stage::imitation_finetune);
  EXPECT_FALSE(after({kOther}).undone_unless_clean);
  EXPECT_FALSE(has_clean_round(history_of({kNearly, kNearer, kNearer, kNearer}), {}));
}

TEST(Plan, RefinesWhatIsNearlyCleanFourTimesInARow) {
  TrainerOptions options = not_before(5);
  options.rate_period = 0;
  const std::string rest = ", barrier_decrease 3, rollout_safety ",
                    first = "search, refines (1), labels, backtracks; rate 0.1949" + rest +
                            "0.6, obstacle_normal 0.6";
  expect_plans(
      options,
      {{"few", 4 * kBad + Rounds{kFew}, first},
       {"none by sampling", 4 * kBad + Rounds{kHidden}, first},
       {"too many", 4 * kBad + Rounds{{200}}, kSearch + "0.5905"},
       {"second", 4 * kBad + Rounds{kFew, kHidden},
        "search, refines (2), labels, backtracks; rate 0.1754" + rest + "0.36, obstacle_normal 0.36"},
       {"fourth", 4 * kBad + 4 * kFew,
        "search, refines (4), labels, backtracks; rate 0.1421" + rest + "0.1296, obstacle_normal 0.1296"},
       {"then one at full rates", 4 * kBad + 5 * kFew, kSearch + "0.3874"},
       {"then again", 4 * kBad + 6 * kFew,
        "search, refines (1), labels, backtracks; rate 0.1151" + rest + "0.6, obstacle_normal 0.6"},
       {"a bad round ends the row", 4 * kBad + Rounds{kFew, kBad}, kSearch + "0.5314"}});
  options.refine = false;
  expect_plans(options, {{"off", 4 * kBad + Rounds{kFew}, kSearch + "0.5905"}});
}

// f stays, so that what holds of V stays true while B trains, and the other way round.
TEST(Plan, RepairsOnlyWhatIsViolated) {
  const TrainerOptions options;
  const RoundPlan round = plan(history_of(2 * kBad), options);
  const auto repaired = [&](std::int64_t of_V, std::int64_t of_B) {
    RoundSummary row{.round = 1};
    row.counts[static_cast<std::size_t>(Condition::lyapunov_decrease)] = of_V;
    row.counts[static_cast<std::size_t>(Condition::barrier_decrease)] = of_B;
    row.found_by_sampling = of_V + of_B;
    EXPECT_EQ(is_repairable(row), of_V + of_B > 0 && of_V + of_B < 200);
    const RoundPlan repair = repair_plan(round, row, options);
    EXPECT_FALSE(repair.trains.f);
    EXPECT_EQ(repair.loss.weight[LossTerm::lyapunov], options.loss.weight[LossTerm::lyapunov]);
    return std::pair{repair.trains.V, repair.trains.B};
  };
  EXPECT_EQ(repaired(3, 0), std::pair(true, false));
  EXPECT_EQ(repaired(0, 3), std::pair(false, true));
  EXPECT_EQ(repaired(3, 3), std::pair(true, true));
  repaired(150, 50);
  repaired(0, 0);
}

TEST(Plan, FineTunesAfterTheFirstCleanRoundAndIsMoreCarefulAfterFailures) {
  expect_plans({}, {{"at once", {kClean}, kFinetune + ", imitation 10"},
                    {"first clean round", kFirstClean, kFinetune + ", imitation 10"},
                    {"failed", kFirstClean + 1 * kNotFinetuned, kFinetune + ", imitation 2.5"},
                    {"no less than 1", kFirstClean + 2 * kNotFinetuned, kFinetune},
                    {"dares more again", kFirstClean + 1 * kNotFinetuned + 1 * kFinetuned,
                     kFinetune + ", imitation 3.75"},
                    {"no more than at first", kFirstClean + 2 * kFinetuned, kFinetune + ", imitation 10"},
                    {"three were kept", kFirstClean + 3 * kFinetuned, kFinetune + ", imitation 10"},
                    {"four were kept", kFirstClean + 4 * kFinetuned, enlarge(0.01, "")},
                    {"nine failed", kFirstClean + 9 * kNotFinetuned, kFinetune},
                    {"ten failed", kFirstClean + 10 * kNotFinetuned, enlarge(0.01, "")}});
}

TEST(Plan, EndsFineTuningWhereFIsAsCloseAsWithoutConditions) {
  std::vector<RoundSummary> history = history_of(kFirstClean + 1 * kFinetuned);
  history.front().mse = 1.0;
  history.back().mse = 0.71;
  EXPECT_EQ(plan(history, {}).stage, Stage::imitation_finetune);
  history.back().mse = 0.69;
  EXPECT_EQ(plan(history, {}).stage, Stage::enlarge);
}

TEST(Plan, ThenEnlargesAndEnds) {
  TrainerOptions options;
  options.imitation_finetune_rounds = 0;
  options.enlarge_rounds = 3;
  expect_plans(
      options,
      {{"first clean round", kFirstClean, enlarge(0.01, "")},
       {"it grew", kFirstClean + 1 * kEnlarged, enlarge(0.005, ", rollout_safety 1.5")},
       {"failed", kFirstClean + Rounds{kEnlarged, kNotEnlarged}, enlarge(0.0, ", rollout_safety 0.75")},
       {"failed twice", kFirstClean + 2 * kNotEnlarged, enlarge(0.0, ", rollout_safety 0.25")},
       {"the end", kFirstClean + Rounds{kEnlarged, kNotEnlarged, kEnlarged}, "finished"}});
  options.enlarge_rounds = 7;
  expect_plans(options, {{"grew often", kFirstClean + 6 * kEnlarged, enlarge(0.0, ", rollout_safety 4")}});
  options.enlarge_rounds = 1;
  expect_plans(options, {{"the first is the last", kFirstClean, enlarge(0.0, "")}});
  options.rollout_points = 0;
  expect_plans(options, {{"nothing to enlarge by", kFirstClean, "finished"}});
}

TEST(Plan, EndsWithoutACertificate) {
  TrainerOptions options = not_before(5);
  options.rounds = 7;
  expect_plans(options, {{"one to go", 6 * kBad, kSearch + "0.5314"}, {"none to go", 7 * kBad, "finished"}});
  EXPECT_FALSE(has_clean_round(history_of(7 * kBad), options));
  EXPECT_FALSE(has_clean_round(history_of({kBad, kClean}), options)) << "before min_rounds";
  EXPECT_TRUE(has_clean_round(history_of(kFirstClean + 1 * kNotFinetuned), options));
}

TEST(Plan, AsksForNoMoreThanTheOptionsDo) {
  TrainerOptions options;
  options.backtrack = false;
  expect_plans(options, {{"no backtracking", {kBad}, "search, labels; rate 0.9"}});
  options.rollout_points = 0;
  expect_plans(options, {{"no labels either", {kBad}, "search; rate 0.9"}});
  expect_plans(imitation_training(),
               {{"f alone", {kBad}, "search; rate 0.9"}, {"its end", 5 * kBad, "finished"}});
  expect_plans(paper_training(), {{"the paper's", 10 * kFew, "search; rate 0.3487"}});
  EXPECT_THROW(plan({}, options), Error);
}

}  // namespace
}  // namespace s2nnds
