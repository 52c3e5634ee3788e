// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "s2nnds/problem/region.h"
#include "s2nnds/runs/run_record.h"

namespace s2nnds {

// What was displaced of a scene in which all else is as it was.
struct DisplacedObstacle {
  std::int64_t index = -1;  // of a union, from 0 in the order of problem.unsafe.of; -1: all of it
  Vector p = {};            // [places], in the coordinates in which the obstacle is written
};

// None where nothing was displaced, where something else changed too, and for obstacles whose place no key tells (expressions,
// half-spaces, maps).
std::optional<DisplacedObstacle> displaced_obstacle(const RegionOptions& before, const RegionOptions& after);

// Which range of a certified run (scene_range.h) holds the scene that `settings` make of it, in one line; "" where none does.
// A hint: nothing is thrown for settings that are wrong.
std::string range_hint(const RunRecord& record, const std::vector<std::string>& settings);

}  // namespace s2nnds
