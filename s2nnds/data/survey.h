// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// A place that two demonstrations pass in directions that differ by more than 60 degrees, where x' = f(x) has one,
// unless they go on together, to a twentieth of the extent after a tenth of it; or one that a demonstration comes back to,
// in whatever direction: a solution of x' = f(x) would go round for ever.
struct Crossing {
  std::size_t first, second;       // demonstrations; the same one where it comes back
  double first_time, second_time;  // s since their starts
  Vector place;                    // [n], between the two positions
  double angle;                    // rad, between the two directions: 0 to pi
};

// A stop on the way: a place where f would be 0, so that a motion x' = f(x) never left it.
struct Pause {
  std::size_t demonstration;
  double start, duration;  // s since its start, s
  Vector place;            // [n]
};

// What demonstrations as read are like, before anything is learned. Lengths in their unit, times in s.
struct Survey {
  Vector duration;                  // [K]
  Vector usual_speed, peak_speed;   // [K] median and largest |velocity|
  Vector closing;                   // [K] distance of the last position from the first
  Vector lower, upper;              // [n] the box around all positions
  double extent = 0;                // its longest side
  double start_spread = 0;          // largest distance of a first position from their mean
  double end_spread = 0;            // largest distance of a last position from their mean
  std::vector<Crossing> crossings;  // at most one a pair of demonstrations, that of the largest angle
  std::vector<Pause> pauses;        // slower than a hundredth of the peak speed for a tenth of the duration

  // Whether demonstration k ends where it starts, to a twentieth of the extent.
  bool is_closed(Eigen::Index k) const { return closing[k] < 0.05 * extent; }
};

// Crossings are looked for among some 200 places a demonstration, evenly spaced along it (fewer of more than 30
// demonstrations), outside of a twentieth of the extent around the mean of the ends. Throws Error as
// check_demonstrations does.
Survey survey(const DemonstrationSet& set);

// `count` >= 2 positions, evenly spaced along the path: [count, n]. Where it has no length, its first position.
Points along_path(const Points& position, Eigen::Index count);

}  // namespace s2nnds
