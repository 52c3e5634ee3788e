// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/core/options.h"
#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// Which demonstrations to read, and what to do with them.
struct DataOptions {
  std::string source = "handwriting";  // handwriting (shipped, synthetic), lasa, ds_opt, csv, hdf5
  std::string file;                    // lasa, ds_opt, hdf5: one file, relative to the data directory
  std::string motion = "Sine";         // handwriting: Sine, S, C, N, Spiral, Helix
  std::vector<std::string> files;      // csv: one file for each demonstration, relative to the data directory
  std::int64_t stride = 1;             // >= 1: keep every stride-th sample (and the last one)
  std::string unit;                    // csv, hdf5: unit of length in the files ("mm"), for reports
  std::string normalization = "max_abs";  // scales by the largest coordinate (max_abs) or norm (max_norm)
  std::vector<std::int64_t> use;  // demonstrations to use at all, from 0, in this order; empty: every one
  std::vector<std::int64_t> test = {5, 6};  // held out, counted from 0 among those in use
  // Held out as well, counted as `test`, for choosing among runs: a choice made on test demonstrations would
  // spoil their figures.
  std::vector<std::int64_t> validation;

  void visit(FieldVisitor& v);  // names only the keys that `source` has
};

// Reads, checks, picks `use` and thins; positions, times and velocities stay as they are in the files.
// Relative paths count from `data_dir`. Readers throw Error with path, what was found and what was expected.
DemonstrationSet read_demonstrations(const DataOptions& options, const std::string& data_dir);

// The readers below keep every stride-th sample and the last one; where a file has no velocities, they
// differentiate what is left, since thinning first amplifies noise least.

// MATLAB (5 to 7, not 7.3): cell array demos{k} of structs with pos [n, M] mm, t [1, M] s, vel [n, M] mm/s.
DemonstrationSet read_lasa(const std::string& path, std::int64_t stride = 1);

// MATLAB (5 to 7, not 7.3): cell array data{k} of [2n, M], positions (m) above velocities (m/s); with 2 rows
// or an odd number of rows, positions alone. Optional scalar dt, s; else 0.01 s.
DemonstrationSet read_ds_opt(const std::string& path, std::int64_t stride = 1);

// Text, one file a demonstration, first line `time,x,y[,z][,dx,dy[,dz]]` or, for any n,
// `time,x1,...,xn[,dx1,...,dxn]`. Unit: "". Numbers use the decimal point in every locale.
DemonstrationSet read_csv(const std::vector<std::string>& paths, std::int64_t stride = 1);

// HDF5: a group /demonstrations/K each (sorted by number) with time [M], position [M, n] and, optionally,
// velocity [M, n]. Unit: "".
DemonstrationSet read_hdf5(const std::string& path, std::int64_t stride = 1);

// Derivative of the parabola through three neighbouring samples: central in the interior, one-sided at the
// ends, on any increasing time grid; error O(h^2). time [M], position [M, n] -> [M, n], M >= 2 (two samples:
// their slope). Throws Error on other shapes and on times that do not increase.
Points differentiate(const Vector& time, const Points& position);

// Where data files live: `flag` if given, else $S2NNDS_DATA, else ../shared/data where it exists, else ""
// (paths count from the working directory). Throws Error when the one that was given is not a directory.
std::string data_directory(const std::string& flag);

}  // namespace s2nnds
