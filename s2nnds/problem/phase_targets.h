// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/core/random.h"
#include "s2nnds/problem/start_paths.h"

namespace s2nnds {

// Towards the path that should be taken, per distance to it, 1 / normalised time. Beside an obstacle in a narrow loop, f
// must lead back by more than it errs.
inline constexpr double phase_gain = 2.0;

// Where the state is (x, s) with a phase s, a law for all of the workspace is known beforehand: with p(s) the place that a
// demonstration has at s, and v and s' what it does there,
//   x' = v + 2 (p(s) - x) where |p(s) - x| <= 0.35, and 0.7 in that direction beyond,
//   s' as there, at most -0.1 (less near 0, where it is at most -s), and -s for s < 0;
// v and s' fade to 0 from s = 0.1 on, since f vanishes at the goal.
// x comes to the path and s runs out, so |x - p(s)|^2 + c s^2 falls along it for some c. Up to `count` samples of it:
// s is uniform in the workspace; x is so for two thirds of them, and normally distributed around p(s), by 0.2 on each axis,
// for the others; never nearer to p(s) than 0.05, where the demonstrations themselves show the way, and never with the unsafe
// set between it and p(s) (fewer samples than asked for may be found). All normalised. Throws
// Error without demonstrations or without a phase.
VelocityTargets phase_targets(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                              std::int64_t count, RandomStream& random);

// 200 states evenly spaced along each of the demonstrations that do not meet the unsafe set: [k, n + 1]. Motions from X0
// are to pass there, so that a safe set that is of use holds them. It is a thin tube from X0 to the goal, most of whose surroundings may be
// unsafe; where nothing asks for it, B ends up positive across it, and X0 and the goal lie in two parts of {B <= 0}. Throws
// Error without a phase.
Points phase_path(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations);

}  // namespace s2nnds
