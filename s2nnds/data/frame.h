// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// How the data as read becomes what networks, sets and figures of quality are stated in: normalised units
// with the goal at the origin.
//   position -> (position - goal) / position_scale
//   velocity -> velocity / velocity_scale
//   time     -> (time - first time) / time_scale()
// so that d(position)/d(time) = velocity holds in normalised units too.
struct Frame {
  std::string unit;                       // of length in the data: "mm", "m"; "" when unknown
  std::string normalization = "max_abs";  // what the scales are the largest of: max_abs, max_norm
  Points goals;                           // [K, n] in `unit`: the place of each demonstration's goal
  double position_scale = 1.0;            // `unit` per normalised length
  double velocity_scale = 1.0;            // `unit` per second and normalised velocity

  // Seconds per unit of normalised time.
  double time_scale() const { return position_scale / velocity_scale; }

  // Demonstrations as read, K of them, in normalised units. Throws Error when there are not K.
  std::vector<Demonstration> normalize(const std::vector<Demonstration>& as_read) const;

  // Throws Error starting with `where` unless the scales are finite and > 0 and the goals are finite and
  // [count, dimension].
  void check(std::size_t count, Eigen::Index dimension, const std::string& where) const;
};

// The goal of each demonstration is its last position. The scales are taken over all demonstrations: max_abs
// takes the largest absolute coordinate (seen from the goal), max_norm the largest Euclidean norm. Throws
// Error when there is no motion (a scale of zero).
Frame find_frame(const DemonstrationSet& as_read, const std::string& normalization);

}  // namespace s2nnds
