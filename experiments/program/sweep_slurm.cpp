// SPDX-License-Identifier: BSD-3-Clause
#include "sweep_slurm.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/sweeps/slurm.h"

namespace s2nnds::program {
namespace {

namespace fs = std::filesystem;

// The first rung's list is 0, 1, 2, ...; the others' stand in a file.
std::string list_file(const SweepFolder& folder, std::int64_t rung) {
  return folder.file(fmt::format("slurm/rung-{}.txt", rung));
}

std::vector<std::string> words_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> words;
  for (std::string word; file >> word;) words.push_back(word);
  return words;
}

std::vector<std::int64_t> places_of(const SweepState& state) {
  std::vector<std::int64_t> places;
  for (const std::int64_t trial : state.missing) {
    const auto found = std::lower_bound(state.trials.begin(), state.trials.end(), trial);
    places.push_back(found - state.trials.begin());
  }
  return places;
}

void write_list(const SweepFolder& folder, const SweepState& state) {
  if (state.rung == 0) return;
  std::string text;
  for (const std::int64_t trial : state.trials) text += fmt::format("{}\n", trial);
  write_atomic_file(list_file(folder, state.rung), text, "the list of trials");
}

}  // namespace

void submit_sweep(const Sweep& sweep, const SweepFolder& folder, const SweepState& state,
                  const std::string& slurm, std::int64_t threads, std::vector<std::string> command) {
  const SlurmOptions options = parse_slurm(slurm);
  if (state.complete()) {
    fmt::print("{}: all {} trials have a result, nothing to submit\n", sweep.options.name,
               state.trials.size());
    return;
  }
  fs::create_directories(folder.file("slurm"));
  const std::string jobs_file = folder.file("slurm/jobs.txt");
  std::vector<std::string> jobs = words_of(jobs_file);
  const std::vector<std::string> active = active_jobs(jobs);
  if (!active.empty()) {
    fmt::print("{}: {} trials missing; job {} is still in the queue, nothing submitted\n", sweep.options.name,
               state.missing.size(), fmt::join(active, ", "));
    return;
  }
  write_list(folder, state);

  std::vector<std::string> task = command;
  task.insert(task.end(), {"--jobs", "1", "--rung", std::to_string(state.rung), "--only", "$first-$last"});
  const auto total = static_cast<std::int64_t>(state.trials.size());
  const std::int64_t chunk = chunk_of(options, total);
  const std::string array = array_text(places_of(state), chunk);
  const std::string script = folder.file(fmt::format("slurm/array-{}.sh", jobs.size()));
  write_atomic_file(script, batch_script(sweep, folder, options, array, chunk, threads, task),
                    "the job script");
  jobs.push_back(submit(script, {}));
  fmt::print("{}: job {}: {} trials, {} a task, tasks {}\n", sweep.options.name, jobs.back(),
             state.missing.size(), chunk, array);
  if (state.rung + 1 < sweep.options.rungs()) {
    command.insert(command.end(), {"--slurm", slurm});
    const std::string next = folder.file("slurm/next.sh");
    write_atomic_file(next, follow_up_script(sweep, folder, options, command), "the job script");
    fmt::print("{}: job {} submits the next rung\n", sweep.options.name,
               submit(next, {"--dependency=afterany:" + jobs.back()}));
  }
  write_atomic_file(jobs_file, fmt::format("{}\n", fmt::join(jobs, "\n")), "the list of jobs");
}

std::vector<std::int64_t> trials_of_task(const Sweep& sweep, const SweepFolder& folder, std::int64_t rung,
                                         const std::string& places) {
  long first = 0;
  long last = 0;
  char rest = 0;
  const bool read = std::sscanf(places.c_str(), "%ld-%ld%c", &first, &last, &rest) == 2;
  check(read && first >= 0 && last >= first, "--only: expected FIRST-LAST, found \"{}\"", places);
  check(rung < sweep.options.rungs(), "--rung: found {}, expected 0 to {}", rung, sweep.options.rungs() - 1);
  std::vector<std::int64_t> trials;
  if (rung == 0) {
    for (std::int64_t k = first; k <= std::min<std::int64_t>(last, sweep.trials_a_rung() - 1); ++k)
      trials.push_back(k);
    return trials;
  }
  const std::vector<std::string> list = words_of(list_file(folder, rung));
  check(!list.empty(), "{}: found no list of trials; expected one from --slurm", list_file(folder, rung));
  for (std::size_t k = first; k <= static_cast<std::size_t>(last) && k < list.size(); ++k) {
    trials.push_back(std::stol(list[k]));
  }
  return trials;
}

}  // namespace s2nnds::program
