// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/problem/region.h"

namespace s2nnds::studio {

// What a person drew, in `unit` and in the plane of the page: demonstrations, obstacles, where motions start, and the
// field, which is the workspace of the motion that is learned from it.
struct Drawing {
  std::string name = "motion";                  // of the motion, for file names and headers
  std::string unit = "m";                       // of all lengths
  std::vector<double> field = {0, 0, 1, 0.75};  // its corner of least coordinates, then the other one
  std::int64_t seed = 0;                        // of training, >= 0
  std::vector<Demonstration> strokes;           // time in seconds, position [M, 2]; no velocities
  std::vector<RegionOptions> obstacles;         // ball, box, polygon
  RegionOptions initial = {.type = "auto"};     // auto, box or ball
};

// Reads what the page sends. Throws Error with what was found and expected: a key that is missing or of another kind,
// numbers that are not finite, more than 64 strokes, 50,000 samples, 64 obstacles or 256 corners.
Drawing drawing_from(const nlohmann::json& json);

// The same as the page has it.
nlohmann::ordered_json to_json(const Drawing& drawing);
// One set as the page has it; null for one that it cannot draw by its own shapes.
nlohmann::ordered_json shape_json(const RegionOptions& region);
// The obstacles of an unsafe set that are all ball, box or polygon, not inflated, as the page has them; null otherwise.
nlohmann::ordered_json obstacles_json(const RegionOptions& unsafe);

// The demonstrations as a table with the columns demonstration, time, x and y.
std::string demonstrations_csv(const Drawing& drawing);
// The unsafe set as the value of problem.unsafe, on one line.
std::string unsafe_toml(const Drawing& drawing);
// The configuration that trains on demonstrations.csv beside it. Demonstrations that end apart by more than a
// hundredth of their extent are moved to end at one point.
std::string configuration(const Drawing& drawing);

}  // namespace s2nnds::studio
