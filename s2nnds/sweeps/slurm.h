// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "s2nnds/sweeps/sweep_folder.h"

namespace s2nnds {

// How a sweep goes to a cluster's Slurm: --slurm partition=cpu,time=02:00:00,throttle=200,chunk=20. What is
// left out is the cluster's own default.
struct SlurmOptions {
  std::map<std::string, std::string> sbatch = {};  // partition, account, qos; time and mem of a task
  std::int64_t throttle = 0;                       // tasks that run at once; 0: no limit
  std::int64_t chunk = 0;  // trials of a task, one after another; 0: as few as give at most 1000 tasks
};

// Throws Error on an unknown name or a bad value.
SlurmOptions parse_slurm(const std::string& text);

// Trials of a task: what was asked for, or what keeps the array below Slurm's usual MaxArraySize of 1001.
std::int64_t chunk_of(const SlurmOptions& options, std::int64_t trials);

// The tasks, counted from 0, that still have something to do, as sbatch's --array wants them: "0-3,7".
// `positions` are places in the rung's list of trials, ascending.
std::string array_text(const std::vector<std::int64_t>& positions, std::int64_t chunk);

// The batch script of the array. `command` runs the trials from place $first to place $last.
std::string batch_script(const Sweep& sweep, const SweepFolder& folder, const SlurmOptions& options,
                         const std::string& array, std::int64_t chunk, std::int64_t threads,
                         const std::vector<std::string>& command);

// The batch script that calls `command` again once a job is over.
std::string follow_up_script(const Sweep& sweep, const SweepFolder& folder, const SlurmOptions& options,
                             const std::vector<std::string>& command);

// Hands the script to sbatch and returns the job's number. Throws Error with what sbatch says when it
// refuses, and when there is no sbatch.
std::string submit(const std::string& script, const std::vector<std::string>& words);

// Those of the jobs that wait or run.
std::vector<std::string> active_jobs(const std::vector<std::string>& jobs);

}  // namespace s2nnds
