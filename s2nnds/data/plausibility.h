// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// What no arm does: beyond these bounds a unit or a time stamp is wrong.
struct PlausibilityOptions {
  double duration = 3600;  // longest demonstration, s, > 0
  // Fastest motion in the data's unit per second, >= 0. 0: 20 m/s in m, cm or mm, 50 rad/s in rad or deg, and
  // in another unit 100 times the motion's extent per second.
  double speed = 0;
  // Largest ratio of two demonstrations' extents, >= 1. Beyond it one of them is in another unit.
  double extents = 50;

  void visit(FieldVisitor& v);  // names each field once
};

// Throws Error naming demonstration and column for a demonstration beyond the bounds, for extents that differ
// too much, and where recorded velocities are not of the size that positions and times give (5 times more or
// less). time_columns [K]: the names in the files, "" where there is none. Demonstrations in seconds.
void check_plausible(const DemonstrationSet& set, const std::vector<std::string>& time_columns,
                     const PlausibilityOptions& options);

}  // namespace s2nnds
