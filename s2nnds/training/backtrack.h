// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "s2nnds/networks/dynamics.h"
#include "s2nnds/problem/safety_problem.h"

namespace s2nnds {

// What a round trains besides, where motions entered {B > 0}.
struct Backtracked {
  Points upstream;  // [k, n]: B should be positive here
  Points position,  // [m, n]
      velocity;     // [m, n]: what f should be at `position`
};

// Options of backtrack().
struct BacktrackOptions {
  std::int64_t motions = 64;  // motions that are followed back, at most; >= 0
  double level_band = 0.01;   // eps_B > 0: at their ends |B| is less than this
  // Speed towards the nearest demonstration sample per distance to it, 1 / normalised time, >= 0: small, as
  // the velocities of f are.
  double gain = 0.5;
};

// The motions that come to `ends` [N, n], one a row, followed back until they leave the box,
// or for twice its diagonal: [M, n] each, the end first, `spacing` apart. Midpoint rule on velocity / |velocity|, in float:
// for training.
std::vector<Points> motions_to(const Dynamics& dynamics, const Points& ends, const Box& within,
                               double spacing);

// Of `counterexamples` [N, n] the last ones at which Bdot >= 0 and |B| < level_band are taken, and the
// motions that come to them. One that passes X0 must be led elsewhere: f is to have the velocity of the
// nearest demonstration sample (`position`, `velocity` [K, n]) plus gain times the way to it, in places. The motions of
// the others end in {B > 0}, so B must be positive all along them, up to the edge of the workspace. The
// losses at the counterexamples themselves could make do with an f that is nearly still there.
Backtracked backtrack(const Networks& networks, const SafetyProblem& problem, const Points& counterexamples,
                      const Points& position, const Points& velocity, const BacktrackOptions& options);

}  // namespace s2nnds
