// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "s2nnds/conditions/condition.h"
#include "s2nnds/core/random.h"
#include "s2nnds/training/counterexample.h"

namespace s2nnds {

// The rows with the largest rank [N], at most `most`, largest first; NaN counts as largest.
std::vector<Eigen::Index> worst_rows(const Vector& rank, std::size_t most);

// Of points x [N, n] of the region where a condition applies, those with the largest `rank` [N] (of a residual in any
// precision), at most 500, climb: each tries normal steps, ever shorter, within the workspace, and takes those that raise
// its residual (in double). Where the condition does not apply it never comes; `onto`, unless
// empty, moves what a step leads to back to where it does, for thin sets. Of the ends, those that violate the condition
// count; those whose residual is above -near (>= 0) are handed on, too, for training: in many dimensions violations are
// left in so many places that few of them are found at a time.
Counterexamples climb(Condition condition, const Networks& networks, const SafetyProblem& problem,
                      double level_band, const Points& x, const Vector& rank, double near,
                      RandomStream& random, const std::function<void(Points&)>& onto = {});

}  // namespace s2nnds
