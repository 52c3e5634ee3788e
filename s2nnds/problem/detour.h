// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/data/demonstration.h"
#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/problem/start_paths.h"

namespace s2nnds {

// A way around the unsafe set for demonstrations (normalised) that pass through it: shown nothing else, f is led into the
// set, and the conditions can only tear {B <= 0} in two there, one part around X0 and one around the goal, so that no
// certificate exists. What lies within `clearance` (normalised, per axis, >= 0) of the set is displaced in one direction
// across the way, with a smooth rise before it and fall after it, just so far that what is displaced is clear (some 200
// samples of a path are looked at). Demonstrations that pass at one place are displaced to one side, that which takes the
// least in all. These are the displaced samples alone: none of demonstrations that do not pass through or that start or end
// too near, nor of those of one place where one of them would leave the contained set or go farther than 1. Of a path,
// what lies beyond its eighth passage stays.
VelocityTargets detour_samples(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                               double clearance);

}  // namespace s2nnds
