// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/sweeps/sweep.h"

namespace s2nnds {

// Where a sweep keeps everything, on one machine or on a disk that a cluster's nodes share:
//   sweep.toml, configs/       what is being swept, frozen when it starts
//   runs/0012/0012345.h5       a trial's run file; beside it .json, its result, and .log, what it printed
//   table.h5, table.csv        the results in one table
//   figures/, slurm/           what the report draws; job scripts and the logs of Slurm's tasks
// A thousand trials share a folder of runs/, since file systems are slow with much larger ones.
class SweepFolder {
 public:
  // Touches no file.
  explicit SweepFolder(std::string path) : path_(std::move(path)) {}

  const std::string& path() const { return path_; }                               // of the folder
  std::string file(const std::string& name) const { return path_ + "/" + name; }  // path of a file in it
  std::string sweep_file() const { return file("sweep.toml"); }                   // the frozen sweep's file
  // The frozen copy of this configuration.
  std::string config(const BaseConfig& base) const { return file("configs/" + base.name + ".toml"); }

  // A trial's run file, relative to the folder, so that tables stay right when it is moved.
  static std::string run_name(std::int64_t trial);
  std::string run(std::int64_t trial) const { return file(run_name(trial)); }  // its run file
  std::string result(std::int64_t trial) const;                                // its TrialResult
  std::string log(std::int64_t trial) const;                                   // what it printed
  void make_run_folder(std::int64_t trial) const;  // for these files; throws Error when it cannot

  // Copies the sweep's file and its configurations here; the copy is a sweep's file of the same trials.
  // A sweep that is there already may get more points. Throws Error when the folder holds another sweep.
  void freeze(const Sweep& sweep) const;

 private:
  std::string path_;
};

}  // namespace s2nnds
