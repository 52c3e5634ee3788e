// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/evaluation/rollout.h"
#include "s2nnds/problem/start_paths.h"

namespace s2nnds {

// How far the motion from a demonstration's first point is from that demonstration: distances of places that
// are matched in order, whenever they are passed. Normalised units; a phase does not count.
struct Deviation {
  double mean = 0.0;     // over the matched pairs
  double largest = 0.0;  // of them: the demonstration is followed within this distance
  double limit = 0.0;    // largest mean with which the motion counts as following it
  bool follows() const { return mean <= limit; }
};

// One for each demonstration (normalised). Both paths are cut into 200 places evenly spaced along them and
// matched by dynamic time warping, so that speed does not count. Places of a demonstration within `margin` of
// the unsafe set do not count either: no safe motion follows it there. The limit is `limit`, or the mean
// distance to the nearest other demonstration where that is more, but 1.5 `limit` at most: f has one velocity
// at each place and cannot be near to all.
std::vector<Deviation> deviations(const StateFunction& f, const SafetyProblem& problem,
                                  const std::vector<Demonstration>& demonstrations, double limit,
                                  double margin, const RolloutOptions& options = {});

// The same for motions from `starts` [N, n]: of each, the deviation from the demonstration that it follows
// best, by mean / limit. The limit is that demonstration's and a third of the distance between both starts:
// the mean distance of a motion that comes nearer as start_paths.h says. It is infinite where the path of
// start_paths.h would lead through the unsafe set, so that the motion must go another way. Throws Error
// without demonstrations.
std::vector<Deviation> start_deviations(const StateFunction& f, const SafetyProblem& problem,
                                        const std::vector<Demonstration>& demonstrations,
                                        const Points& starts, double limit, double margin,
                                        const RolloutOptions& options = {});

// Of the motions from the demonstrations' first points and from `starts` [N, n], those whose deviation is
// more than 0.8 of its limit: at places along them and along the path that they should take (start_paths.h),
// the velocity there, and back to it. Where a demonstration strays so far, all others that keep off the unsafe set
// are among them, a third as often; where one is not followed, only demonstrations. None where a demonstration
// leads through the unsafe set and the motion stops there. Where the state has a phase, it tells the place to go to,
// and is not led back itself.
// Normalised units. Throws Error without demonstrations.
VelocityTargets corrections_of(const StateFunction& f, const SafetyProblem& problem,
                               const std::vector<Demonstration>& demonstrations, const Points& starts,
                               double limit, double margin, const RolloutOptions& options = {});

// The largest mean / limit: at most 1 where every demonstration is followed. 0 without demonstrations.
double worst_share(const std::vector<Deviation>& deviations);

}  // namespace s2nnds
