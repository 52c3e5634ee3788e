// SPDX-License-Identifier: BSD-3-Clause
#include "sweep_command.h"

#include <fmt/format.h>

#include <filesystem>

#include "local_sweep.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/platform.h"
#include "s2nnds/core/python_module.h"
#include "s2nnds/data/readers.h"
#include "sweep_report.h"
#include "sweep_slurm.h"
#include "sweep_trial.h"

namespace s2nnds::program {
namespace {

namespace fs = std::filesystem;

constexpr int kInterrupted = 130;

std::string absolute(const std::string& path) {
  return path.empty() ? "" : fs::absolute(path).lexically_normal().string();
}

LocalMeans means_of(const Sweep& sweep, const SweepArguments& arguments, const CommonArguments& common) {
  LocalMeans means;
  means.program = arguments.program.empty() ? executable_path() : absolute(arguments.program);
  means.data = absolute(data_directory(common.data));
  means.threads = common.threads > 0 ? common.threads : sweep.options.threads;
  const int cores = available_cores();
  const int room = std::max(1, static_cast<int>(cores / means.threads));
  means.jobs = arguments.jobs > 0 ? std::min(arguments.jobs, room) : room;
  if (arguments.jobs > room) {
    fmt::print(stderr, "{} trials of {} threads would be more than the {} cores; running {} at once\n",
               arguments.jobs, means.threads, cores, means.jobs);
  }
  return means;
}

// A task of a job array: its part of the list, one after another. Slurm starts it again after a node failed.
int run_task(const Sweep& sweep, const SweepFolder& folder, const SweepArguments& arguments,
             const LocalMeans& means) {
  std::vector<std::int64_t> missing;
  std::vector<TrialResult> there;
  for (const std::int64_t trial : trials_of_task(sweep, folder, arguments.rung, arguments.only)) {
    if (auto result = read_result(folder.result(trial))) {
      there.push_back(std::move(*result));
    } else {
      missing.push_back(trial);
    }
  }
  return run_trials(sweep, folder, means, there, missing) ? kVerified : kInterrupted;
}

int report(const Sweep& sweep, const SweepFolder& folder, bool json) {
  const SweepState state = read_state(sweep, folder);
  check(!state.results.empty(), "{}: found no results yet, expected some to report", folder.path());
  const bool reached = report_sweep(sweep, folder, state, json);
  const int drawn = run_python_module("sweep --report", "plot_sweep",
                                      {folder.file("table.h5"), "--out", folder.file("figures")});
  return drawn != 0 ? drawn : reached ? kVerified : kNotVerified;
}

void check_arguments(const SweepArguments& arguments) {
  const int modes = (arguments.dry_run ? 1 : 0) + (arguments.report ? 1 : 0) +
                    (arguments.slurm.empty() ? 0 : 1) + (arguments.trial ? 1 : 0) +
                    (arguments.only.empty() ? 0 : 1);
  check(modes <= 1, "sweep: expected at most one of --dry-run, --report, --slurm, --trial and --only");
}

}  // namespace

int sweep(const SweepArguments& arguments, const CommonArguments& common) {
  check_arguments(arguments);
  const Sweep sweep = read_sweep(arguments.sweep);
  if (arguments.dry_run) {
    print_trials(sweep, common.json);
    return kVerified;
  }
  const SweepFolder folder(absolute(arguments.out.empty() ? sweep.options.name + "-sweep" : arguments.out));
  const LocalMeans means = means_of(sweep, arguments, common);
  const bool frozen = fs::exists(folder.sweep_file()) && fs::equivalent(arguments.sweep, folder.sweep_file());
  if (!frozen) {
    check(!arguments.report || fs::exists(folder.sweep_file()), "{}: found no sweep, expected one to report",
          folder.path());
    folder.freeze(sweep);
  }
  if (arguments.trial) {
    CommonArguments of_trial = common;
    of_trial.threads = static_cast<int>(means.threads);
    return run_trial(sweep, folder, *arguments.trial, of_trial);
  }
  if (!arguments.only.empty()) return run_task(sweep, folder, arguments, means);
  if (arguments.retry_failed) forget_failed(folder, read_state(sweep, folder));
  if (arguments.report) return report(sweep, folder, common.json);
  if (!arguments.slurm.empty()) {
    std::vector<std::string> command = {executable_path(), "sweep",     folder.sweep_file(),          "--out",
                                        folder.path(),     "--threads", std::to_string(means.threads)};
    if (!means.data.empty()) command.insert(command.end(), {"--data", means.data});
    if (!arguments.program.empty()) command.insert(command.end(), {"--program", means.program});
    submit_sweep(sweep, folder, read_state(sweep, folder), arguments.slurm, means.threads, command);
    return kVerified;
  }
  const auto state = run_sweep(sweep, folder, means);
  if (!state) return kInterrupted;
  return report_sweep(sweep, folder, *state, common.json) ? kVerified : kNotVerified;
}

}  // namespace s2nnds::program
