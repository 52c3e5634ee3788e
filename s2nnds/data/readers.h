// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/data/cleaning.h"
#include "s2nnds/data/column_names.h"
#include "s2nnds/data/demonstration.h"
#include "s2nnds/data/plausibility.h"
#include "s2nnds/data/recording.h"
#include "s2nnds/data/split.h"

namespace s2nnds {

// How a table of numbers is read.
struct TableOptions {
  ColumnOptions columns;           // which of them are what
  std::string delimiter = "auto";  // csv: between cells: auto (as found), comma, semicolon, tab, blanks
  double rate = 0;                 // samples per second of files without times, >= 0; 0: they have times
  // What moves: "position", "phase" (positions and the part of the path that is left, so that motions can cross
  // themselves or end where they start), "auto" (phase for motions in the plane that need it, else position), "pose"
  // (positions with an orientation, which columns.quaternion or columns.rotation name) or "joints" (angles in rad or
  // deg, unwrapped: no step is more than a quarter of a turn, and all demonstrations end within half a turn of the first
  // one's end). Pose and joints: csv, npy, mat, hdf5.
  std::string state = "auto";
};

// For readers of files without orientations, where state is "pose".
inline constexpr const char* kNoOrientation =
    "found no orientations; expected data.columns.quaternion or data.columns.rotation to name them";

// Which demonstrations to read, and what to do with them.
struct DataOptions : TableOptions {
  std::string source = "handwriting";  // handwriting (shipped, synthetic), lasa, ds_opt, csv, npy, mat, hdf5
  std::string file;                    // lasa, ds_opt: one file, relative to the data directory
  std::string motion = "Sine";         // handwriting: Sine, S, C, N, Spiral, Helix
  // csv, npy, mat, hdf5: files, folders or patterns (d*.csv), relative to the data directory; in a csv file, a new value
  // of data.columns.index and blank lines begin a new demonstration.
  std::vector<std::string> files;
  // pose: of the numbers in files, "xyzw" or "wxyz"; auto: as the columns' names say, xyzw in HDF5 files as imported, else
  // training refuses, since no check can see the wrong order. Policies take this order.
  std::string quaternion_order = "auto";
  std::string time_unit = "auto";  // of times in the files: s, ms, us, ns; auto: recognised, and reported
  std::int64_t stride = 1;         // >= 1: keep every stride-th sample (and the last one)
  std::string unit;  // csv, npy, mat, hdf5: of length in the files: m, mm, cm, rad, deg or another text
  // Where the motion's goal lies: "mean" (of the demonstrations' ends), or a point [n] in `unit`, both of which
  // leave the demonstrations where they are; or "each": every demonstration is moved to end at the mean.
  WordOrNumbers goal = {"mean"};
  std::string frame_name;  // of the frame of the positions ("base_link"), for reports and exports
  std::string normalization = "max_abs";  // scales by the largest coordinate (max_abs) or norm (max_norm)
  std::vector<std::int64_t> use;  // demonstrations to use at all, from 0, in this order; empty: every one
  // Held out, counted from 0 among those in use. [-1]: the last fifth of them, none of fewer than four.
  std::vector<std::int64_t> test = {kTestByShare};
  // Held out as well, counted as `test`, for choosing among runs: a choice made on test demonstrations would
  // spoil their figures.
  std::vector<std::int64_t> validation;
  CleaningOptions cleaning;    // what is done to recordings first; positions that are left stay as they are
  PlausibilityOptions limits;  // csv, npy, mat, hdf5: what no arm does is refused

  void visit(FieldVisitor& v);  // names only the keys that `source` has
};

// Called now and then while much is read: what is done ("reading d.csv", "cleaning d.csv"), and which share of it.
using ReadingProgress = std::function<void(const std::string& what, double share)>;
inline constexpr std::int64_t samples_a_tick = 250'000;  // between two calls

// Reads, picks `use`, brings times to seconds, cleans, checks and thins; the report says what was done.
// Positions and recorded velocities that are left stay as they are in the files. Relative paths count from `data_dir`. Throws Error with path, what was found and what was
// expected.
DemonstrationSet read_demonstrations(const DataOptions& options, const std::string& data_dir,
                                     const ReadingProgress& progress = {});

// MATLAB (5 to 7.3): cell array demos{k} of structs with pos [n, M] mm, t [1, M] s, vel [n, M] mm/s.
RecordingSet read_lasa(const std::string& path);

// MATLAB (5 to 7.3): cell array data{k} of [2n, M], positions (m) above velocities (m/s); with 2 rows
// or an odd number of rows, positions alone. Optional scalar dt, s; else 0.01 s.
RecordingSet read_ds_opt(const std::string& path);

// Text: a table of numbers, a sample a line. Comments (#), a header, other columns and text in them, quotes and
// a decimal comma (where commas do not part the cells) are understood; values that are missing become NaN.
// Numbers use the decimal point in every locale. Several demonstrations in a file: see DataOptions::files.
RecordingSet read_csv(const std::vector<std::string>& paths, const TableOptions& options = {},
                      const ReadingProgress& progress = {});

// MATLAB (5 to 7.3), any layout: matrices [M, n] or [n, M] of real numbers named time, position and, optionally,
// velocity, or as options.columns says (several positions stand side by side): variables, of which cell arrays hold a
// demonstration a cell; or the fields of the structures in the structure or cell array options.columns.index.
RecordingSet read_mat(const std::vector<std::string>& paths, const TableOptions& options = {});

// NumPy. An .npy file is a table [M, columns], or [K, M, columns] of K demonstrations, whose columns are told by
// number as those of a CSV file without header. An .npz file has arrays time [M] or [K, M], position [M, n]
// or [K, M, n] and, optionally, velocity of the same shape; options.columns names them otherwise.
RecordingSet read_npy(const std::vector<std::string>& paths, const TableOptions& options = {});

// HDF5: a group of demonstrations (sorted by number), each with time [M], position [M, n] and, optionally,
// velocity [M, n]. options.columns names the group (`index`) and the data sets in its members; several that make
// up the positions stand side by side. Its attribute `unit` is the unit of length. Without names: /demonstrations/K/time, position, velocity; robomimic's
// /data/demo_K/obs/robot0_eef_pos, whose times count by the control frequency in the file.
RecordingSet read_hdf5(const std::string& path, const TableOptions& options = {},
                       const ReadingProgress& progress = {});

// Derivative of the parabola through three neighbouring samples: central in the interior, one-sided at the
// ends, on any increasing time grid; error O(h^2). time [M], position [M, n] -> [M, n], M >= 2 (two samples:
// their slope). Throws Error on other shapes and on times that do not increase.
Points differentiate(const Vector& time, const Points& position);

// Where data files live: `flag` if given, else $S2NNDS_DATA, else ../shared/data where it exists, else ""
// (paths count from the working directory). Throws Error when the one that was given is not a directory.
std::string data_directory(const std::string& flag);

}  // namespace s2nnds
