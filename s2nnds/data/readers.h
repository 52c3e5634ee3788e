#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/core/options.h"
#include "s2nnds/data/demonstration.h"

namespace s2nnds {

struct DataOptions {
  std::string source = "handwriting";  // handwriting (shipped, synthetic), lasa, ds_opt, csv, hdf5
  std::string file;                    // lasa, ds_opt, hdf5: one file, relative to the data directory
  std::string motion = "Sine";         // handwriting: Sine, S, C, N, Spiral, Helix
  std::vector<std::string> files;      // csv: one file a demonstration
  std::int64_t stride = 1;             // keep every stride-th sample (and the last one)
  std::string unit;                    // csv: unit of length, for reports
  std::string normalization = "max_abs";       // max_abs, max_norm
  std::vector<std::int64_t> test = {5, 6};     // demonstrations held out, counted from 0
  std::vector<std::int64_t> use;               // demonstrations to use at all; empty: every one

  void visit(FieldVisitor& v);
};

// Reads, checks, thins and translates to the goal (the last position of each demonstration becomes the origin).
// Every reader throws Error with path, what was found and what was expected.
DemonstrationSet read_demonstrations(const DataOptions& options, const std::string& data_dir);

DemonstrationSet read_lasa(const std::string& path);     // demos{n}.pos/.t/.vel, mm
DemonstrationSet read_ds_opt(const std::string& path);   // data{n} [2n, T], optional dt, m
DemonstrationSet read_csv(const std::vector<std::string>& paths);  // time,x,y[,z][,dx,dy[,dz]]
DemonstrationSet read_hdf5(const std::string& path);     // /demonstrations/K/{time,position[,velocity]}

// Central differences in the interior, one-sided at the ends, on any time grid (second order): [M, n].
Points differentiate(const Vector& time, const Points& position);

// Where data files live: `flag` if given, else $S2NNDS_DATA, else ../shared/data where it exists, else "".
std::string data_directory(const std::string& flag);

}  // namespace s2nnds
