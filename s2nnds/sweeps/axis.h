// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace s2nnds {

// One axis of a sweep: a dotted key of the configuration, others that take the same value, and what values.
// Values are kept as TOML text, since that is what a configuration is overridden with.
struct Axis {
  std::string key;                     // dotted, of the configuration
  std::vector<std::string> also = {};  // other keys that take the same value
  std::int64_t line = 0;               // of the sweep's file, for messages

  std::vector<std::string> values = {};  // a list; empty: a range
  double low = 0.0;                      // lower end of a range, included; > 0 if logarithmic
  double high = 1.0;                     // upper end of a range, included
  bool logarithmic = false;              // the range is covered evenly in its logarithm
  bool integer = false;                  // both ends were written as integers
  std::int64_t count = 0;                // grid points of a range; 0: the sweep's file does not say

  // The value at u in [0, 1): lists and integers in equal shares.
  std::string at(double u) const;
  // The values of a grid: the list, or `count` values from end to end (whole numbers: without repetitions).
  // Throws Error when a range has no count.
  std::vector<std::string> grid() const;
  // The list, or the ends of the range: when these are admissible, so is what lies between.
  std::vector<std::string> extremes() const;
};

// The table `axes` of a sweep's file, in the order of its lines:
//   "training.loss.decay_rate" = [0.05, 0.1, 0.2]
//   "training.rate_f" = { log_range = [1e-4, 1e-2], count = 5 }
//   "networks.f.hidden" = { values = [[32, 32], [64, 64]], also = ["networks.V.hidden"] }
// Throws Error with source, line, what was found and what was expected.
std::vector<Axis> read_axes(const std::string& text, const std::string& source);

}  // namespace s2nnds
