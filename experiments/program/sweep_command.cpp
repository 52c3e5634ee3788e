#include "sweep_command.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstring>
#include <deque>
#include <filesystem>
#include <map>

#include "python_script.h"
#include "s2nnds/core/check.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/sweeps/process_pool.h"
#include "sweep_progress.h"
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

std::string own_path() { return fs::read_symlink("/proc/self/exe").string(); }

// Two pools in one folder would run every trial twice.
class FolderLock {
 public:
  explicit FolderLock(const SweepFolder& folder) {
    file_ = ::open(folder.file("lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    check(file_ >= 0, "{}: cannot write into it: {}", folder.path(), std::strerror(errno));
    const bool taken = ::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (taken) ::close(file_);
    check(!taken, "{}: another sweep is running in this folder; expected none", folder.path());
  }
  ~FolderLock() { ::close(file_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

// What a sweep runs its trials with.
struct Means {
  std::string program;
  std::string data;
  std::int64_t threads = 1;
  int jobs = 1;
};

Means means_of(const Sweep& sweep, const SweepArguments& arguments, const CommonArguments& common) {
  Means means;
  means.program = arguments.program.empty() ? own_path() : absolute(arguments.program);
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

// Runs trials in child processes of this program.
class LocalSweep {
 public:
  LocalSweep(const Sweep& sweep, const SweepFolder& folder, const Means& means)
      : sweep_(sweep),
        folder_(folder),
        means_(means),
        pool_({{"OMP_WAIT_POLICY", "passive"}, {"OMP_NUM_THREADS", std::to_string(means.threads)}}) {}

  // Returns whether all came to their end, rather than being interrupted.
  bool run(const std::vector<std::int64_t>& trials, SweepProgress& progress) {
    std::deque<std::int64_t> waiting(trials.begin(), trials.end());
    while (!waiting.empty() || pool_.running() > 0) {
      while (!waiting.empty() && pool_.running() < static_cast<std::size_t>(means_.jobs)) {
        start(waiting.front());
        waiting.pop_front();
      }
      progress.draw(pool_.running());
      const auto end = pool_.wait(1.0);
      if (pool_.interrupted()) return false;
      if (!end) continue;
      if (end->signal != 0 && ++killed_[end->id] <= sweep_.options.retries) {
        progress.note(fmt::format("trial={} was killed by signal {}; it goes on from its last round", end->id,
                                  end->signal));
        waiting.push_front(end->id);
      } else {
        progress.ended(result_of(*end));
      }
    }
    return true;
  }

 private:
  void start(std::int64_t trial) {
    folder_.make_run_folder(trial);
    PoolJob job{trial, {}, folder_.log(trial)};
    job.command = {
        means_.program,        "sweep",     folder_.sweep_file(),          "--out", folder_.path(), "--trial",
        std::to_string(trial), "--threads", std::to_string(means_.threads)};
    if (!means_.data.empty()) job.command.insert(job.command.end(), {"--data", means_.data});
    pool_.start(job);
  }

  // A trial writes its own result, unless something ended its process.
  TrialResult result_of(const PoolEnd& end) const {
    if (auto result = read_result(folder_.result(end.id))) return *result;
    TrialResult result;
    result.trial = end.id;
    result.failed = true;
    result.seconds = end.seconds;
    result.error = end.signal != 0
                       ? fmt::format("killed by signal {}, {} times", end.signal, killed_.at(end.id))
                       : fmt::format("ended with exit code {} and no result", end.exit_code);
    write_result(folder_.result(end.id), result);
    return result;
  }

  const Sweep& sweep_;
  const SweepFolder& folder_;
  Means means_;
  ProcessPool pool_;
  std::map<std::int64_t, std::int64_t> killed_;  // how often, by trial
};

void forget_failed(const SweepFolder& folder, const std::vector<TrialResult>& results) {
  for (const TrialResult& result : results) {
    if (result.failed) fs::remove(folder.result(result.trial));
  }
}

int interrupted() {
  fmt::print(stderr, "stopped; the same command goes on\n");
  return kInterrupted;
}

// A task of a job array: its part of the list, one after another. Slurm starts it again after a node failed.
int run_task(const Sweep& sweep, const SweepFolder& folder, const SweepArguments& arguments,
             const Means& means) {
  std::vector<std::int64_t> missing;
  std::vector<TrialResult> there;
  for (const std::int64_t trial : trials_of_task(sweep, folder, arguments.rung, arguments.only)) {
    if (auto result = read_result(folder.result(trial))) {
      there.push_back(std::move(*result));
    } else {
      missing.push_back(trial);
    }
  }
  SweepProgress progress(sweep, there, missing.size(), means.jobs);
  LocalSweep local(sweep, folder, means);
  const bool all = local.run(missing, progress);
  progress.finish();
  return all ? kVerified : interrupted();
}

// All rungs, one after another.
int run_here(const Sweep& sweep, const SweepFolder& folder, const Means& means, bool json) {
  const FolderLock lock(folder);
  SweepState state = read_state(sweep, folder);
  while (!state.complete()) {
    SweepProgress progress(sweep, state.of_rung, state.missing.size(), means.jobs);
    LocalSweep local(sweep, folder, means);
    const bool all = local.run(state.missing, progress);
    progress.finish();
    if (!all) return interrupted();
    state = read_state(sweep, folder);
  }
  const EffectTable effects = estimate_effects(sweep, state.of_rung);
  write_tables(sweep, folder, state, effects);
  return print_report(sweep, folder, state, effects, json) ? kVerified : kNotVerified;
}

int report(const Sweep& sweep, const SweepFolder& folder, const CommonArguments& common) {
  const SweepState state = read_state(sweep, folder);
  check(!state.results.empty(), "{}: found no results yet, expected some to report", folder.path());
  const EffectTable effects = estimate_effects(sweep, state.of_rung);
  write_tables(sweep, folder, state, effects);
  const int drawn = run_python("sweep --report", S2NNDS_PLOT_SWEEP_SCRIPT,
                               {folder.file("table.h5"), "--out", folder.file("figures")});
  const bool reached = print_report(sweep, folder, state, effects, common.json);
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
  const Means means = means_of(sweep, arguments, common);
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
  if (arguments.retry_failed) forget_failed(folder, read_state(sweep, folder).results);
  if (arguments.report) return report(sweep, folder, common);
  if (!arguments.slurm.empty()) {
    std::vector<std::string> command = {own_path(),    "sweep",     folder.sweep_file(),          "--out",
                                        folder.path(), "--threads", std::to_string(means.threads)};
    if (!means.data.empty()) command.insert(command.end(), {"--data", means.data});
    if (!arguments.program.empty()) command.insert(command.end(), {"--program", means.program});
    submit_sweep(sweep, folder, read_state(sweep, folder), arguments.slurm, means.threads, command);
    return kVerified;
  }
  return run_here(sweep, folder, means, common.json);
}

}  // namespace s2nnds::program
