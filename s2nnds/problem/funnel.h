// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/core/random.h"
#include "s2nnds/data/demonstration.h"
#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/problem/start_paths.h"

namespace s2nnds {

// Places beside the demonstrations and how f should lead from there: along the nearest demonstration and towards it, as
// fast as that is. Followed backwards such motions leave the way that is shown, and so do the starts whose motions
// meet an obstacle beside it: elsewhere than here f would be what the conditions make of it.
struct FunnelOptions {
  double reach = 0.3;  // normalised, > 0: the farthest of the places
  // Of the way towards the demonstration per distance to it and distance along it, 1 / normalised length, >= 0.
  double steepness = 2.0;
};

// At most `count` such places, evenly along the demonstrations (normalised). Left out are those outside of the workspace,
// in the unsafe set or with it between them and the demonstration, those nearer to the goal than to twice the
// distance from the demonstration, and those whose surroundings, to one and a half times that distance, hold
// demonstrations that go other ways. None where there are no demonstrations.
VelocityTargets funnel_samples(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                               std::int64_t count, RandomStream& random, const FunnelOptions& options = {});

}  // namespace s2nnds
