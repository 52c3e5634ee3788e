// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/guarantee.h"

#include <algorithm>

namespace s2nnds {
namespace {

bool proof_says(Verdict wanted, Condition condition, const std::vector<ConditionVerdict>& verdicts) {
  return std::any_of(verdicts.begin(), verdicts.end(), [&](const ConditionVerdict& found) {
    return found.method == Method::proof && found.condition == condition && found.verdict == wanted;
  });
}

bool all_passed(Method method, const std::vector<ConditionVerdict>& verdicts) {
  bool any = false;
  for (const ConditionVerdict& found : verdicts) {
    if (found.method != method) continue;
    if (found.verdict != Verdict::passed) return false;
    any = true;
  }
  return any;
}

// Points that violate a condition are known whatever passed elsewhere.
bool samples_refute(const std::vector<ConditionVerdict>& verdicts, const SafetyProblem& problem) {
  return std::any_of(verdicts.begin(), verdicts.end(), [&](const ConditionVerdict& found) {
    const bool counts = found.condition != Condition::containment || problem.workspace_margin;
    return counts && found.verdict == Verdict::failed && found.violations > 0;
  });
}

}  // namespace

Guarantee guarantee_of(const std::vector<ConditionVerdict>& verdicts, const SideConditions& side,
                       const SafetyProblem& problem) {
  bool proved = true, refuted = false;
  for (const Condition condition : all_conditions) {
    if (condition == Condition::containment && !problem.workspace_margin) continue;
    proved = proved && proof_says(Verdict::proved, condition, verdicts);
    refuted = refuted || proof_says(Verdict::refuted, condition, verdicts);
  }
  if (refuted || samples_refute(verdicts, problem)) return Guarantee::none;
  if (proved && side.goal_holds()) {
    const bool contained = proof_says(Verdict::proved, Condition::containment, verdicts);
    return contained && side.hold() ? Guarantee::invariant : Guarantee::proved;
  }
  if (all_passed(Method::conformal, verdicts)) return Guarantee::conformal;
  return all_passed(Method::sampled, verdicts) ? Guarantee::sampled : Guarantee::none;
}

}  // namespace s2nnds
