// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "s2nnds/core/random.h"
#include "s2nnds/problem/safety_problem.h"

namespace s2nnds {

// How a motion from a start that was not shown should go: like the demonstration whose start is the nearest,
// displaced by the way from that start to this one. The displacement falls as (1 - s)^2 along the path, s the
// share of its length.

// The index of the demonstration whose first point is the nearest to `start` [n]. Throws Error without
// demonstrations.
std::size_t nearest_start(const std::vector<Demonstration>& demonstrations, const Vector& start);

// The factors (1 - s)^2 at the rows of a path [M, n]: [M]; 0 where the path has no length.
Vector displacement_along(const Points& path);

// Such motions from `starts` [N, n], normalised as the demonstrations, as samples to train on: positions and
// the velocities of the displaced path, at most `samples` >= 2 of each, even in time. Where the displacement
// is less than 0.01 the demonstration itself shows the way, so a path ends there; starts nearer than 0.03
// have none. Throws Error without demonstrations.
std::vector<Demonstration> start_paths(const std::vector<Demonstration>& demonstrations, const Points& starts,
                                       std::int64_t samples);

// What f should be at some places.
struct VelocityTargets {
  Points position,  // [K, n]
      velocity;     // [K, n]
};

// `count` points of X0 that cover it well: of sixteen times as many drawn, each one that is the farthest from
// the demonstrations' starts and from those taken before it, so that the first are the ones least like what
// was shown. [count, n], [0, n] where X0 is null or has no volume.
Points spread_starts(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                     std::int64_t count, RandomStream& random);

}  // namespace s2nnds
