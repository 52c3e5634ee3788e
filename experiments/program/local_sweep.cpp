// SPDX-License-Identifier: BSD-3-Clause
#include "local_sweep.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <deque>
#include <filesystem>
#include <map>

#include "s2nnds/core/check.h"
#include "s2nnds/sweeps/process_pool.h"

namespace s2nnds::program {
namespace {

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

// Says on stderr how far a sweep is: one line a trial.
class Progress {
 public:
  Progress(const Sweep& sweep, const std::vector<TrialResult>& before, std::size_t missing)
      : sweep_(sweep), total_(before.size() + missing) {
    for (const TrialResult& result : before) take(result);
  }

  void ended(const TrialResult& result) {
    take(result);
    ++ended_here_;
    if (result.failed) {
      fmt::print(stderr, "trial={} failed: {}\n", result.trial, result.error);
      return;
    }
    const std::string& objective = sweep_.options.objective;
    fmt::print(stderr, "{}/{} trial={} {} guarantee={} {}={:.4g} seconds={:.1f} best={} failed={} left={}\n",
               ended_, total_, result.trial, sweep_.label(sweep_.trial(result.trial)), result.guarantee,
               objective, result.metric(objective), result.seconds,
               best_ ? fmt::format("{:.4g} (trial {})", best_->metric(objective), best_->trial) : "none",
               failed_, time_left());
  }

 private:
  void take(const TrialResult& result) {
    ++ended_;
    failed_ += result.failed ? 1 : 0;
    const auto badness = [&](const TrialResult& of) {
      return (sweep_.options.direction == "maximize" ? -1.0 : 1.0) * of.metric(sweep_.options.objective);
    };
    if (!counts(sweep_.options, result) || !std::isfinite(badness(result))) return;
    if (!best_ || badness(result) < badness(*best_)) best_ = result;
  }
  // From the trials that ended since this process started: all that is known of the speed of this machine.
  std::string time_left() const {
    const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
    const long s = std::lround(elapsed / ended_here_ * static_cast<double>(total_ - ended_));
    return fmt::format("{:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  }

  const Sweep& sweep_;
  std::size_t total_, ended_ = 0, failed_ = 0;
  int ended_here_ = 0;
  std::optional<TrialResult> best_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

PoolJob job_of(std::int64_t trial, const SweepFolder& folder, const LocalMeans& means) {
  PoolJob job{trial, {}, folder.log(trial)};
  job.command = {
      means.program,         "sweep",     folder.sweep_file(),          "--out", folder.path(), "--trial",
      std::to_string(trial), "--threads", std::to_string(means.threads)};
  if (!means.data.empty()) job.command.insert(job.command.end(), {"--data", means.data});
  return job;
}

// A trial writes its own result, unless something ended its process. `killed`: how often it was.
TrialResult result_of(const PoolEnd& end, const SweepFolder& folder, std::int64_t killed) {
  if (auto result = read_result(folder.result(end.id))) return *result;
  TrialResult result;
  result.trial = end.id;
  result.failed = true;
  result.seconds = end.seconds;
  result.error = end.signal != 0 ? fmt::format("killed by signal {}, {} times", end.signal, killed)
                                 : fmt::format("ended with exit code {} and no result", end.exit_code);
  write_result(folder.result(end.id), result);
  return result;
}

}  // namespace

bool run_trials(const Sweep& sweep, const SweepFolder& folder, const LocalMeans& means,
                const std::vector<TrialResult>& before, const std::vector<std::int64_t>& trials) {
  Progress progress(sweep, before, trials.size());
  ProcessPool pool({{"OMP_WAIT_POLICY", "passive"}, {"OMP_NUM_THREADS", std::to_string(means.threads)}});
  std::map<std::int64_t, std::int64_t> killed;  // how often, by trial
  std::deque<std::int64_t> waiting(trials.begin(), trials.end());
  while (!waiting.empty() || pool.running() > 0) {
    while (!waiting.empty() && pool.running() < static_cast<std::size_t>(means.jobs)) {
      folder.make_run_folder(waiting.front());
      pool.start(job_of(waiting.front(), folder, means));
      waiting.pop_front();
    }
    const auto end = pool.wait(1.0);
    if (pool.interrupted()) {
      fmt::print(stderr, "stopped; the same command goes on\n");
      return false;
    }
    if (!end) continue;
    if (end->signal != 0 && ++killed[end->id] <= sweep.options.retries) {
      fmt::print(stderr, "trial={} was killed by signal {}; it goes on from its last round\n", end->id,
                 end->signal);
      waiting.push_front(end->id);
    } else {
      progress.ended(result_of(*end, folder, killed[end->id]));
    }
  }
  return true;
}

std::optional<SweepState> run_sweep(const Sweep& sweep, const SweepFolder& folder, const LocalMeans& means) {
  const FolderLock lock(folder);
  SweepState state = read_state(sweep, folder);
  while (!state.complete()) {
    if (!run_trials(sweep, folder, means, state.of_rung, state.missing)) return std::nullopt;
    state = read_state(sweep, folder);
  }
  return state;
}

void forget_failed(const SweepFolder& folder, const SweepState& state) {
  for (const TrialResult& result : state.results) {
    if (result.failed) std::filesystem::remove(folder.result(result.trial));
  }
}

}  // namespace s2nnds::program
