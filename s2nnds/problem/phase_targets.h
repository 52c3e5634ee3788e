// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/core/random.h"
#include "s2nnds/problem/start_paths.h"

namespace s2nnds {

// Where the state is (x, s) with a phase s, a law for all of the workspace is known beforehand: with p(s) the place that a
// demonstration has at s, and v and s' what it does there,
//   x' = v + (p(s) - x) where |p(s) - x| <= 0.7, and 0.7 in that direction beyond,
//   s' as there, at most -0.1 (less near 0, where it is at most -s), and -s for s < 0;
// v and s' fade to 0 from s = 0.1 on, since f vanishes at the goal.
// x comes to the path and s runs out, so |x - p(s)|^2 + c s^2 falls along it for some c. Up to `count` samples of it:
// s is uniform in the workspace; x is so for two thirds of them, and normally distributed around p(s), by 0.2 on each axis,
// for the others; never nearer to p(s) than 0.05, where the demonstrations themselves show the way, and never with the unsafe
// set between it and p(s) (fewer samples than asked for may be found). All normalised. Throws
// Error without demonstrations or without a phase.
VelocityTargets phase_targets(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                              std::int64_t count, RandomStream& random);

}  // namespace s2nnds
