// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/plan.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

using History = std::vector<RoundSummary>;

// Below this factor of the rates a round hardly changes anything.
constexpr double kLeastRate = 0.05;

// With every restart these weights fall by these factors: what could not be certified must give way
// somewhere. Where motions fan out before the obstacle, those that meet it come through a gap so narrow that
// rollout labels which fill it leave no room for B to fall. The motion that is certified then may pass the
// obstacle on the other side than the demonstrations.
constexpr double kRelaxedImitation = 0.5;
constexpr double kRelaxedRollouts = 0.3;
// A certificate of a motion that does not follow the demonstrations is not taken: what strays is corrected,
// with more weight on imitation after each, at most twice; every third one is followed by a new start. So
// many are tried.
constexpr double kMoreImitation = 2.0;
constexpr std::int64_t kUnfaithfulRounds = 6, kUnfaithfulInARow = 3;
// So many rounds in a row whose f and B no certificate can have: training does not leave such a shape.
constexpr std::int64_t kImpossibleRounds = 4;
// A round with at most so many counterexamples is not followed by a new start for its age, so many rounds long: the
// shape is right, and another one may not be.
constexpr std::int64_t kAlmostClean = 50, kGrace = 5;

// A certificate of a motion that is at most so far from the demonstrations, as a share of what is allowed, is kept, and
// so many rounds bring it nearer to them: what is left to learn is less than a new certificate.
constexpr double kNearlyFollows = 1.5;
constexpr std::int64_t kApproachingRounds = 3;
constexpr double kApproachingImitation = 2.5;  // at first; less after rounds that are undone

// A round is nearly clean with fewer counterexamples than this, or if random search found none of them. The
// next one refines: its rates are lower, so that what holds already stays, and the weights of what presses {B
// = 0} against the motions, where Bdot < 0 is hard to meet, fall with every such round.
constexpr std::int64_t kNearlyClean = 200;
constexpr double kRefinedRate = 0.33;
constexpr double kRefinedRollouts = 0.6;
constexpr double kRefinedDecrease = 3.0;
// So many refine in a row. A row that ends without success is followed by a round at full rates: what is left
// may lie in the shape of the functions.
constexpr std::int64_t kRefiningRounds = 4;

constexpr double kFinetunedImitation = 10.0;  // at first; see careful()
constexpr double kFinetunedRate = 0.3;        // what is certified must stay nearly as it is

// Fine-tuning ends with an error of this share of the warm start's, which only the funnel held back, or after so many
// rounds that were kept: further ones did not lower the error on demonstrations that f had not seen.
constexpr double kFitted = 0.7;
constexpr std::int64_t kFinetunedRounds = 4;

constexpr std::int64_t kRepairs = 2;  // what f moved by little, V and B can follow

// At first, at least and at most, see careful(). All labels are of points that B does not hold safe, so each counts
// several times as much as one of any point.
constexpr double kEnlargedRollouts = 1.0, kLeastEnlargedRollouts = 0.1, kMostEnlargedRollouts = 4.0;
constexpr double kEnlargedMayLose = 0.01;  // see lost_at_most()
constexpr double kEnlargedMargins = 2.0;   // of the conditions on B, which its growth must not break
constexpr double kEnlargedRate = 0.5;
constexpr std::int64_t kEnlargedRepairs = 1;  // a round that is undone brings nothing

// Factors of a weight after a round that ended clean, and after one that did not and was undone: where
// fine-tuning breaks a certificate it takes far less weight, and a round that is undone costs the most.
constexpr double kAdvance = 1.5, kFinetunedRetreat = 0.25, kEnlargedRetreat = 0.5;

bool labels_rollouts(const TrainerOptions& options) {
  return options.rollout_points > 0 && options.loss.weight[LossTerm::rollout_safety] > 0.0;
}

std::int64_t rounds_in(const History& history, Stage stage) {
  return std::count_if(history.begin(), history.end(),
                       [=](const RoundSummary& row) { return row.stage == stage; });
}

bool is_nearly_clean(const RoundSummary& row, const TrainerOptions& options) {
  if (row.round < options.min_rounds || row.stage != Stage::search || row.clean()) return false;
  return row.counterexamples() < kNearlyClean || row.found_by_sampling == 0;
}

std::int64_t refining_round(const History& history, const TrainerOptions& options) {
  if (!options.refine) return 0;
  const auto other = std::find_if(history.rbegin(), history.rend(),
                                  [&](const RoundSummary& row) { return !is_nearly_clean(row, options); });
  return std::distance(history.rbegin(), other) % (kRefiningRounds + 1);
}

struct Careful {
  double first, least, most, retreat;
};

// A weight's factor, at first and within limits: less by `retreat` after each round of the stage that did not end
// clean, more after each one that did.
double careful(const History& history, Stage stage, const Careful& by) {
  double factor = by.first;
  for (const RoundSummary& row : history) {
    if (row.stage == stage)
      factor = std::clamp(factor * (row.clean() ? kAdvance : by.retreat), by.least, by.most);
  }
  return factor;
}

// Rounds that bring a certified motion nearer to the demonstrations.
struct Approach {
  std::int64_t left = 0;   // of them, 0: the next round is none
  double deviation = 0.0;  // of what is kept, > 1
  double weight = 0.0;     // factor of imitation
};

// Calls `visit` with each round of the search but those that approach. Returns what the next round is.
template <typename Visit>
Approach each_searching(const History& history, const TrainerOptions& options, Visit visit) {
  Approach now;
  for (const RoundSummary& row : history) {
    if (row.round == 0 || row.stage != Stage::search) continue;
    if (now.left > 0) {
      --now.left;
      const bool kept = row.clean() && row.deviation <= now.deviation;
      if (kept) now.deviation = row.deviation;
      now.weight = std::clamp(now.weight * (kept ? kAdvance : kFinetunedRetreat), 1.0, kApproachingImitation);
      continue;
    }
    visit(row);
    if (row.round >= options.min_rounds && row.clean() && !row.follows() && row.deviation <= kNearlyFollows)
      now = {kApproachingRounds, row.deviation, kApproachingImitation};
  }
  return now;
}

// Why a round of the search starts anew.
struct Restarts {
  std::int64_t age = 0;          // rounds since the last one
  std::int64_t by_age = 0;       // after rate_period rounds
  std::int64_t by_shape = 0;     // what B and f had become no certificate can have
  std::int64_t by_fidelity = 0;  // certificates, but of another motion than the demonstrations'
  std::int64_t unfaithful = 0;   // such certificates in all
};

Restarts restarts_of(const History& history, const TrainerOptions& options) {
  Restarts found;
  std::int64_t impossible = 0;
  each_searching(history, options, [&](const RoundSummary& row) {
    ++found.age;
    impossible = row.is_impossible() && row.round >= options.min_rounds ? impossible + 1 : 0;
    std::int64_t* reason = nullptr;
    const bool unfaithful = row.clean() && !row.follows();
    if (unfaithful) ++found.unfaithful;
    if (unfaithful && found.unfaithful % kUnfaithfulInARow == 0) {
      reason = &found.by_fidelity;
    } else if (options.rate_period > 0 && impossible >= kImpossibleRounds) {
      reason = &found.by_shape;
    } else if (options.rate_period > 0 && found.age >= options.rate_period &&
               (row.counterexamples() > kAlmostClean || found.age >= options.rate_period + kGrace)) {
      reason = &found.by_age;
    }
    if (!reason) return;
    ++*reason;
    found.age = impossible = 0;
  });
  return found;
}

RoundPlan fitting_plan(Stage stage, double weight, const TrainerOptions& options) {
  RoundPlan plan = {.stage = stage,
                    .undone_unless_clean = true,
                    .repairs = kRepairs,
                    .rate = kFinetunedRate,
                    .loss = options.loss};
  plan.loss.weight[LossTerm::imitation] *= weight;
  return plan;
}

RoundPlan search_plan(const History& history, const TrainerOptions& options) {
  if (const Approach now = each_searching(history, options, [](const RoundSummary&) {}); now.left > 0) {
    RoundPlan plan = fitting_plan(Stage::search, now.weight, options);
    plan.largest_deviation = now.deviation;
    return plan;
  }
  const Restarts restarts = restarts_of(history, options);
  const std::int64_t all = restarts.by_age + restarts.by_shape + restarts.by_fidelity;
  RoundPlan plan = {.rate = std::max(kLeastRate, std::pow(options.rate_decay, restarts.age)),
                    .loss = options.loss};
  PerTerm<double>& weight = plan.loss.weight;
  plan.starts_anew = all > 0 && restarts.age == 0;
  plan.backtracks = options.backtrack && weight[LossTerm::barrier_decrease] > 0.0;  // else B is no barrier
  const auto press_less = [&](double factor, double times) {
    weight[LossTerm::rollout_safety] *= std::pow(factor, times);
    weight[LossTerm::obstacle_normal] *= std::pow(factor, times);
  };
  weight[LossTerm::imitation] *= std::pow(kMoreImitation, std::min<std::int64_t>(restarts.unfaithful, 2));
  // f that points outwards all around an obstacle has an equilibrium in it.
  if (all % 2 == 1) weight[LossTerm::obstacle_normal] = 0.0;
  if (options.relax_weights) {
    weight[LossTerm::imitation] *= std::pow(kRelaxedImitation, restarts.by_age);
    press_less(kRelaxedRollouts, static_cast<double>(restarts.by_age));
  }
  if (all == 0 && std::ssize(history) <= options.barrier_rounds) {
    plan.trains = Trains::barrier();
    weight[LossTerm::imitation] = weight[LossTerm::lyapunov] = weight[LossTerm::obstacle_normal] = 0.0;
    return plan;
  }
  if (options.refine) plan.repairs = kRepairs;
  plan.refining = plan.starts_anew ? 0 : refining_round(history, options);
  if (plan.refining == 0) return plan;
  plan.rate *= kRefinedRate;
  press_less(kRefinedRollouts, static_cast<double>(plan.refining));
  weight[LossTerm::barrier_decrease] *= kRefinedDecrease;
  return plan;
}

RoundPlan imitation_finetune_plan(const History& history, const TrainerOptions& options) {
  const Careful imitation = {kFinetunedImitation, 1.0, kFinetunedImitation, kFinetunedRetreat};
  return fitting_plan(Stage::imitation_finetune, careful(history, Stage::imitation_finetune, imitation),
                      options);
}

// Whether f is as near to the demonstrations as it will be.
bool is_fitted(const History& history) {
  std::int64_t kept = 0;
  for (const RoundSummary& row : history) {
    if (row.stage != Stage::imitation_finetune || !row.is_kept()) continue;
    if (++kept >= kFinetunedRounds || row.mse < kFitted * history.front().mse) return true;
  }
  return false;
}

// What concerns B alone.
RoundPlan enlarge_plan(const History& history, const TrainerOptions& options) {
  RoundPlan plan = {.stage = Stage::enlarge,
                    .trains = Trains::barrier(),
                    .undone_unless_clean = true,
                    .repairs = kEnlargedRepairs,
                    .rate = kEnlargedRate,
                    .loss = options.loss};
  PerTerm<double>& weight = plan.loss.weight;
  weight[LossTerm::imitation] = weight[LossTerm::lyapunov] = weight[LossTerm::obstacle_normal] = 0.0;
  weight[LossTerm::rollout_safety] *=
      careful(history, Stage::enlarge,
              {kEnlargedRollouts, kLeastEnlargedRollouts, kMostEnlargedRollouts, kEnlargedRetreat});
  weight[LossTerm::barrier_sets] *= kEnlargedMargins;
  weight[LossTerm::barrier_decrease] *= kEnlargedMargins;
  return plan;
}

// The share of {B <= 0} that a round may lose: less from round to round, nothing in the last one.
double lost_at_most(const History& history, const TrainerOptions& options) {
  const std::int64_t left = options.enlarge_rounds - 1 - rounds_in(history, Stage::enlarge);
  return left > 0
             ? kEnlargedMayLose * static_cast<double>(left) / static_cast<double>(options.enlarge_rounds - 1)
             : 0.0;
}

std::int64_t count_of(const RoundSummary& row, Condition condition) {
  return row.counts[static_cast<std::size_t>(condition)];
}

std::int64_t of_lyapunov(const RoundSummary& row) {
  return count_of(row, Condition::lyapunov_positive) + count_of(row, Condition::lyapunov_decrease);
}

RoundPlan stage_plan(const History& history, const TrainerOptions& options) {
  if (!has_clean_round(history, options)) {
    if (history.back().round >= options.rounds) return {.finished = true};
    return search_plan(history, options);
  }
  // What is certified but follows nothing is left as it is.
  const bool follows = std::any_of(history.begin(), history.end(), [&](const RoundSummary& row) {
    return row.round >= options.min_rounds && row.is_kept();
  });
  if (!follows) return {.finished = true};
  if (rounds_in(history, Stage::imitation_finetune) < options.imitation_finetune_rounds &&
      !is_fitted(history))
    return imitation_finetune_plan(history, options);
  // Without rollouts nothing tells where B may be smaller.
  if (!labels_rollouts(options) || rounds_in(history, Stage::enlarge) >= options.enlarge_rounds)
    return {.finished = true};
  RoundPlan plan = enlarge_plan(history, options);
  plan.may_lose = lost_at_most(history, options);
  return plan;
}

}  // namespace

RoundPlan repair_plan(const RoundPlan& round, const RoundSummary& row, const TrainerOptions& options) {
  RoundPlan plan = enlarge_plan({RoundSummary{}}, options);
  plan.stage = round.stage;
  plan.undone_unless_clean = round.undone_unless_clean;
  plan.trains = {.f = false, .V = of_lyapunov(row) > 0, .B = row.counterexamples() > of_lyapunov(row)};
  for (const LossTerm term : {LossTerm::lyapunov, LossTerm::rollout_safety})
    plan.loss.weight[term] = round.loss.weight[term];
  return plan;
}

bool is_repairable(const RoundSummary& row) {
  return !row.clean() && (row.counterexamples() < kNearlyClean || row.found_by_sampling == 0);
}

bool has_clean_round(const History& history, const TrainerOptions& options) {
  if (std::any_of(history.begin(), history.end(),
                  [&](const RoundSummary& row) { return row.round >= options.min_rounds && row.is_kept(); }))
    return true;
  std::int64_t unfaithful = 0;
  const Approach now = each_searching(history, options, [&](const RoundSummary& row) {
    if (row.round >= options.min_rounds && row.clean()) ++unfaithful;
  });
  return unfaithful >= kUnfaithfulRounds && now.left == 0;
}

RoundPlan plan(const History& history, const TrainerOptions& options) {
  check(!history.empty(), "training plan: found no rounds, expected the warm start's at least");
  RoundPlan next = stage_plan(history, options);
  next.labels_rollouts = labels_rollouts(options);
  return next;
}

}  // namespace s2nnds
