// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/certificate.h"

namespace s2nnds {

// The strongest guarantee that the verdicts on one set of weights support. A condition counts unless it is
// containment and the problem has no workspace margin.
//   none       a proof refuted a condition that counts, or a verdict failed with violating samples, whatever else holds
//   invariant  a proof proved every condition, containment always included, and the side conditions
//   proved     a proof proved every condition that counts, f(0) = 0 and V(0) = 0
//   conformal, sampled  every verdict of this method is `passed`, and there is at least one
//   none       otherwise
Guarantee guarantee_of(const std::vector<ConditionVerdict>& verdicts, const SideConditions& side,
                       const SafetyProblem& problem);

}  // namespace s2nnds
