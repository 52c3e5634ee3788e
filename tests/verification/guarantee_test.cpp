// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/guarantee.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

constexpr SideConditions kHold{.goal_is_equilibrium = true,
                               .lyapunov_vanishes_at_goal = true,
                               .goal_is_safe = true,
                               .initial_in_workspace = true};

SafetyProblem problem_with_margin(bool margin) {
  SafetyProblem problem = simple_problem();
  problem.workspace_margin = margin ? problem.unsafe : nullptr;  // any region
  return problem;
}

ConditionVerdict verdict_of(Condition condition, Method method, Verdict verdict) {
  ConditionVerdict found;
  found.condition = condition;
  found.method = method;
  found.verdict = verdict;
  return found;
}

// One verdict on all conditions, `except` for one.
std::vector<ConditionVerdict> verdicts(Method method, Verdict all, Condition except, Verdict other) {
  std::vector<ConditionVerdict> found;
  for (const Condition condition : all_conditions)
    found.push_back(verdict_of(condition, method, condition == except ? other : all));
  return found;
}
std::vector<ConditionVerdict> verdicts(Method method, Verdict all) {
  return verdicts(method, all, Condition::initial, all);
}

Guarantee guarantee(const std::vector<ConditionVerdict>& found, bool margin = true,
                    SideConditions side = kHold) {
  return guarantee_of(found, side, problem_with_margin(margin));
}

TEST(Guarantee, GrowsInStrength) {
  EXPECT_LT(Guarantee::none, Guarantee::sampled);
  EXPECT_LT(Guarantee::sampled, Guarantee::conformal);
  EXPECT_LT(Guarantee::conformal, Guarantee::proved);
  EXPECT_LT(Guarantee::proved, Guarantee::invariant);
}

TEST(Guarantee, NothingCheckedIsNone) { EXPECT_EQ(guarantee({}), Guarantee::none); }

TEST(Guarantee, OfSamples) {
  EXPECT_EQ(guarantee(verdicts(Method::sampled, Verdict::passed)), Guarantee::sampled);
  EXPECT_EQ(guarantee(verdicts(Method::conformal, Verdict::passed)), Guarantee::conformal);
  for (const Method method : {Method::sampled, Method::conformal}) {
    EXPECT_EQ(guarantee(verdicts(method, Verdict::passed, Condition::unsafe, Verdict::failed)),
              Guarantee::none);
  }
}

TEST(Guarantee, InvariantNeedsContainmentAndTheSideConditions) {
  const auto all = verdicts(Method::proof, Verdict::proved);
  EXPECT_EQ(guarantee(all), Guarantee::invariant);
  for (bool SideConditions::*field : {&SideConditions::goal_is_safe, &SideConditions::initial_in_workspace}) {
    SideConditions side = kHold;
    side.*field = false;
    EXPECT_EQ(guarantee(all, true, side), Guarantee::proved);
  }
  for (const Verdict verdict : {Verdict::undecided, Verdict::refuted}) {
    const auto open = verdicts(Method::proof, Verdict::proved, Condition::containment, verdict);
    EXPECT_EQ(guarantee(open, false), Guarantee::proved);  // without a margin, it does not count
    EXPECT_EQ(guarantee(open, true), Guarantee::none);
  }
}

TEST(Guarantee, ProvedNeedsTheGoalToBeAnEquilibriumAndTheLeastPointOfV) {
  for (bool SideConditions::*field :
       {&SideConditions::goal_is_equilibrium, &SideConditions::lyapunov_vanishes_at_goal}) {
    SideConditions side = kHold;
    side.*field = false;
    for (const bool margin : {true, false})
      EXPECT_EQ(guarantee(verdicts(Method::proof, Verdict::proved), margin, side), Guarantee::none);
  }
}

TEST(Guarantee, ProvedNeedsEveryConditionThatCounts) {
  for (const Condition condition : all_conditions) {
    auto found = verdicts(Method::proof, Verdict::proved);
    std::erase_if(found, [&](const ConditionVerdict& verdict) { return verdict.condition == condition; });
    EXPECT_EQ(guarantee(found, true), Guarantee::none) << to_string(condition);
  }
}

TEST(Guarantee, AnUndecidedProofLeavesWhatSamplesSay) {
  auto found = verdicts(Method::proof, Verdict::proved, Condition::unsafe, Verdict::undecided);
  for (const auto& verdict : verdicts(Method::conformal, Verdict::passed)) found.push_back(verdict);
  EXPECT_EQ(guarantee(found), Guarantee::conformal);
}

TEST(Guarantee, ARefutationOutweighsEverySample) {
  for (const Condition condition : all_conditions) {
    auto found = verdicts(Method::proof, Verdict::undecided, condition, Verdict::refuted);
    for (const Method method : {Method::sampled, Method::conformal})
      for (const auto& verdict : verdicts(method, Verdict::passed)) found.push_back(verdict);
    EXPECT_EQ(guarantee(found, true), Guarantee::none) << to_string(condition);
    EXPECT_EQ(guarantee(found, false),
              condition == Condition::containment ? Guarantee::conformal : Guarantee::none);
  }
}

// Every order of every method with every outcome: a refutation leaves nothing, and nothing comes back until the method
// that refuted says something else.
TEST(Guarantee, ARefutationEndsEveryStrongerAndEveryOlderClaim) {
  const auto outcomes = [](Method method) {
    std::vector<Verdict> all = {Verdict::passed, Verdict::failed};
    if (method == Method::proof) all = {Verdict::proved, Verdict::refuted, Verdict::undecided};
    return all;
  };
  std::vector<Method> order = {Method::sampled, Method::conformal, Method::proof};
  int combinations = 0;
  do {
    for (const Verdict a : outcomes(order[0]))
      for (const Verdict b : outcomes(order[1]))
        for (const Verdict c : outcomes(order[2]))
          for (const Condition condition : all_conditions) {
            std::vector<ConditionVerdict> found;
            const Verdict outcome[] = {a, b, c};
            bool refuted = false;
            for (std::size_t i = 0; i < order.size(); ++i) {
              const Verdict good = order[i] == Method::proof ? Verdict::proved : Verdict::passed;
              for (ConditionVerdict each : verdicts(order[i], good, condition, outcome[i])) {
                if (each.verdict == Verdict::failed) each.violations = 1;
                found.push_back(each);
              }
              refuted = refuted || outcome[i] == Verdict::refuted || outcome[i] == Verdict::failed;
              if (refuted) {
                EXPECT_EQ(guarantee(found), Guarantee::none);
              }
            }
            if (!refuted) {
              EXPECT_GE(guarantee(found), Guarantee::conformal);
            }
            ++combinations;
          }
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(combinations, 6 * 12 * 6);
}

TEST(Guarantee, ASetThatNoSampleHitIsNoCounterexample) {
  auto found = verdicts(Method::proof, Verdict::proved);
  for (const auto& verdict : verdicts(Method::sampled, Verdict::passed, Condition::initial, Verdict::failed))
    found.push_back(verdict);  // without a violation
  EXPECT_EQ(guarantee(found), Guarantee::invariant);
}

}  // namespace
}  // namespace s2nnds
