// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "s2nnds/core/options.h"

namespace s2nnds {

// Which columns of a file are what. A column is a name of the file, or its number from 0 as text ("2"). What
// is not named is recognised where the file's names are usual ones (time, Time, %time, t, stamp; x y z, px py,
// pos_x pos_y, pose.position.x, x1 x2 ..., q1 q2 ...; vx vy, dx dy, twist.linear.x; episode, demo). In npz files
// they are names of arrays, in mat files of variables or of the fields of `index`, in hdf5 files of data sets in each demonstration's group, `index` their parent.
struct ColumnOptions {
  std::string time;                   // of the times; none where data.rate counts them
  std::vector<std::string> position;  // of the positions, one a coordinate
  std::vector<std::string> velocity;  // of recorded velocities, as many as positions; "none": differentiate
  std::string index;                  // tells the demonstrations of one file apart: a new value, a new one
  // Of quaternions, four (data.quaternion_order says in which order), where data.state is "pose"; without them those are
  // taken whose names end in x, y, z and w (qx, orientation.w, ...). In npz, mat and hdf5 files one name of [M, 4].
  std::vector<std::string> quaternion;
  // Of rotation matrices in place of quaternions, nine, row by row. In npz and hdf5 files one name of [M, 9] or
  // [M, 3, 3], in mat files of [M, 9].
  std::vector<std::string> rotation;

  void visit(FieldVisitor& v);  // names each field once
};

// The places of the columns in a file.
struct Columns {
  std::optional<std::size_t> time;
  std::vector<std::size_t> position;  // n
  std::vector<std::size_t> velocity;  // n, or none
  std::optional<std::size_t> index;
  std::vector<std::size_t> orientation;  // 4 of a quaternion, 9 of a rotation matrix, or none
  std::string quaternion_order;          // as the names of the 4 say: xyzw, wxyz; "" where they do not
  std::string unit;  // of length as the positions' names say: "x [mm]" -> "mm"; "" when they do not
};

// The columns that `wanted` names, the others by their usual names. With `named` false, `names` are numbers
// from 0: column 0 is the time and two or three others are the position unless `wanted` says otherwise. With
// `timed` false no time is looked for. Throws Error starting with `where` for a column that is not there, a
// choice that is not clear, and fewer than two coordinates.
Columns find_columns(const std::vector<std::string>& names, bool named, bool timed,
                     const ColumnOptions& wanted, const std::string& where);

// A line that says what was chosen: "time 't', position 'px', 'py', not used 'qx'".
std::string describe(const Columns& columns, const std::vector<std::string>& names);

// "s", "ms", "us" or "ns" where a time column's name says it (t_ms, "time [ns]", nsecs), else "".
std::string time_unit_in_name(const std::string& name);

}  // namespace s2nnds
