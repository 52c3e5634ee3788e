// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// One recording as a file holds it, before its times are brought to seconds.
struct Recording {
  std::string where;        // names it in messages: "d0.csv", "d.h5: /demonstrations/3"
  std::string time_column;  // what the file calls its times: "t"; "" when it has none and a rate counts them
  double time_offset = 0;   // subtracted from large integer times before they became doubles, in their unit
  Vector time;              // [M] less time_offset, in the file's unit of time
  Points position;          // [M, n]; NaN where the file has none
  Points velocity;          // [M, n], NaN where missing; [0, 0] when none was recorded
  std::vector<std::int64_t> lines = {};  // [M] of a text file, counted from 1; empty for other files
  // [M, 4] or [M, 9] as files have them, then unit quaternions (orientation_reading.h); [0, 0] when none were read
  Points orientation = {};

  Eigen::Index samples() const { return position.rows(); }  // M
  // Where sample i stands, for messages: "d0.csv:17", "d.h5: /demonstrations/3: sample 17".
  std::string place(Eigen::Index i) const;
  // The same recording with these samples alone, in this order.
  Recording at(const std::vector<Eigen::Index>& samples) const;
};

// The recordings of one motion, as a reader returns them.
struct RecordingSet {
  std::string name;                        // of the motion: the first file's name without folder and ending
  std::string unit;                        // of length: "mm", "m", or "" when the files do not say
  std::vector<Recording> recordings = {};  // in the files' order
  // Seconds per unit of time where the format says so; 0: to be recognised (time_unit.h).
  double time_unit = 0;
  std::vector<std::string> report = {};  // what was chosen while reading, a line each
  bool has_orientations = false;         // whether the files hold orientations, read or not
  std::string quaternion_order = {};  // of quaternions, where names of columns tell it: xyzw, wxyz; "" else
};

// Throws Error naming the place unless the recording has as many times as positions, at least 2 samples in at
// least 2 dimensions, finite numbers and increasing times.
void check_recording(const Recording& recording);

// A recording with times in seconds as a demonstration: checks it, keeps every stride-th sample and the last
// one, and differentiates what is left when no velocity was recorded (thinning first amplifies noise least).
// Throws Error naming the place.
Demonstration make_demonstration(const Recording& recording, std::int64_t stride);

// make_demonstration of each, with the times as they are.
DemonstrationSet make_demonstrations(const RecordingSet& set, std::int64_t stride = 1);

// Throws Error unless `path` is a file that can be read.
void check_readable(const std::string& path);

// The file's name without folder and ending: "lasa/Sine.mat" -> "Sine".
std::string stem(const std::string& path);

}  // namespace s2nnds
