// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "commands.h"

namespace s2nnds::program {

struct SweepArguments {
  std::string sweep;
  std::string out;  // folder; default NAME-sweep
  int jobs = 0;     // trials at once; 0: as many as there are cores for
  bool dry_run = false;
  bool report = false;
  bool retry_failed = false;
  std::string slurm;  // partition=...,time=...
  std::string only;   // FIRST-LAST: places in the rung's list of trials, for one task of a job array
  std::int64_t rung = 0;
  std::optional<std::int64_t> trial;  // runs this trial in this process
  std::string program;                // started for every trial; default: this one
};

// Exit codes beside the usual ones: 3 when no trial has the wanted guarantee, 130 when it was interrupted.
int sweep(const SweepArguments& arguments, const CommonArguments& common);

}  // namespace s2nnds::program
