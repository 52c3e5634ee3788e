// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {

// What moves with a pose besides its position: a capsule in the frame of what is turned, whose origin is the position.
// Where the orientation is the identity, its axes are the data's.
struct ToolOptions {
  std::vector<double> start = {};  // one end of its axis, [3], in the data's unit; none: no tool
  std::vector<double> end = {};    // the other end, [3]
  double radius = 0.0;             // >= 0, in the data's unit
  // Degrees in [0, 90): the obstacle grows by what the tool sweeps while it is turned from the goal's orientation by no
  // more, and what the certificate says of the tool asks for a proof of that. 0: by what it sweeps however it is turned.
  double turn = 0.0;

  void visit(FieldVisitor& v);  // names each field once
  bool is_none() const { return start.empty() && end.empty(); }
};

// The positions at which the tool may touch the obstacle. Of every part of the tool's axis, a point m turned by up to the
// angle a lies on a cap of the sphere of radius |m|, and that in the ball around cos(a) m of radius sin(a) |m|, or for all
// turns around 0 of radius |m|. So the set is covered by copies of the obstacle, each moved by the centre of such a ball,
// turned by the goal's orientation, and inflated by its radius and the tool's, rounding included. `goal` [3, 3] is the
// rotation matrix of that orientation. Throws Error for obstacles that have no written place (expression, polynomial,
// occupancy_image, polygon), and where the tool is not well written.
RegionOptions swept(const RegionOptions& obstacle, const ToolOptions& tool, const Eigen::Matrix3d& goal);

std::string in_words(const ToolOptions& tool,
                     const std::string& unit);  // "a capsule from ... to ... of radius ..."

}  // namespace s2nnds
