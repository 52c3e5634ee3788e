// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/core/points.h"

namespace s2nnds {

// One recorded motion of M samples. As read: seconds and the file's unit of length and frame (LASA: mm;
// ds-opt: m). Normalised: see frame.h.
struct Demonstration {
  Vector time;              // [M] strictly increasing
  Points position;          // [M, n]
  Points velocity;          // [M, n], unit of position per unit of time
  Points orientation = {};  // [M, 4] unit quaternions (orientation.h); [0, 0] without
  std::vector<std::int64_t> lines =
      {};  // [M] of the text file that it was read from; empty where there are none

  Eigen::Index samples() const { return position.rows(); }    // M
  Eigen::Index dimension() const { return position.cols(); }  // n
};

// Demonstrations of one motion, all of dimension n, as a reader returns them.
struct DemonstrationSet {
  std::string name;  // of the motion: the file's name without folder and ending, for handwriting the motion
  std::string unit;  // of length: "mm", "m", or "" when the file does not say
  std::vector<Demonstration> demonstrations;  // in the file's order
  // What was chosen, recognised and cleaned while reading, a line each; of demonstration 3: "3: ...".
  std::vector<std::string> report = {};
  bool has_orientations = false;      // whether the files hold orientations, read or not
  std::string quaternion_order = {};  // of the files' quaternions: xyzw or wxyz; "" where none were read
  // [K] standard deviation of a coordinate about smooth motion, in `unit`; empty where it was not measured.
  std::vector<double> noise = {};

  Eigen::Index dimension() const;  // of its first demonstration; throws Error if there is none
};

// Throws Error naming `source` and the demonstration unless there is at least one demonstration, all have one
// dimension n >= 2, at least 2 samples, equal lengths, finite numbers and increasing times.
void check_demonstrations(const DemonstrationSet& set, const std::string& source);

// The same for one demonstration; `where` names it in the message.
void check_demonstration(const Demonstration& demonstration, const std::string& where);

// The length of the path [M, n] up to each of its points: [M].
Vector arc_lengths(const Points& path);

// The positions of all samples of several demonstrations, one after another: [sum M, n].
Points stack_positions(const std::vector<Demonstration>& demonstrations);
// Their velocities, in the same order: [sum M, n].
Points stack_velocities(const std::vector<Demonstration>& demonstrations);

}  // namespace s2nnds
