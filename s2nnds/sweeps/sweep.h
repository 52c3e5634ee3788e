// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/sweeps/design.h"

namespace s2nnds {

// A configuration that a sweep varies.
struct BaseConfig {
  std::string name;  // the configuration's own
  std::string path;  // of its file
  std::string text;  // TOML, as in the file
};

// One run of a sweep. Its number says which: ((rung * points + point) * configs + config) * seeds + seed,
// each counted from 0; that of its point if the sweep is not crossed.
struct Trial {
  std::int64_t id = 0;             // its number
  std::int64_t rung = 0;           // of successive halving, from 0
  std::int64_t point = 0;          // of Sweep::points, from 0
  std::int64_t config = 0;         // of Sweep::configs, from 0
  std::int64_t seed = 0;           // the run's seed itself
  std::string profile;             // of a listed trial; empty: the configuration's
  std::vector<std::int64_t> test;  // of a listed trial: test demonstrations; empty: the configuration's
};

// A sweep's file, read and checked, with its points worked out.
struct Sweep {
  std::string text;                 // of its file
  SweepOptions options;             // all of the file but its axes
  std::vector<Axis> axes;           // in the file's order
  std::vector<BaseConfig> configs;  // in the file's order
  std::vector<DesignPoint> points;  // make_design of the options and axes
  // Some trial ends with conformal verification. Each of those verifies with its beta / trials(), so that what is said
  // of all of them, and of the one that is chosen, is wrong with a probability of at most beta.
  bool is_conformal = false;
  std::vector<std::int64_t> pairs;  // of each point, config * seeds + seed; empty when crossed or listed

  std::int64_t trials_a_point() const;  // configurations times seeds; 1 if the sweep is not crossed
  std::int64_t trials_a_rung() const;   // if all points are in it
  std::int64_t trials() const;          // of all rungs, if all points are in each
  Trial trial(std::int64_t id) const;   // throws Error when there is none of this number
  std::int64_t id_of(std::int64_t rung, std::int64_t point) const;  // of the point's first trial

  // Its configuration, split, seed and profile in one word: "Sine-seed0", "Sine-test5_6-seed0-imitation".
  std::string label(const Trial& trial) const;

  // "key=value" settings that make the base configuration the trial's own.
  std::vector<std::string> settings(const Trial& trial) const;
};

// Reads the sweep's file and its configurations, and tries every value of every axis on each configuration,
// so that a misspelt key or a value out of range is refused before anything starts. Throws Error.
Sweep read_sweep(const std::string& path);

// The same of a file's text, whose configurations are named relative to `folder`. `source` is for messages.
Sweep parse_sweep(const std::string& text, const std::string& source, const std::string& folder);

}  // namespace s2nnds
