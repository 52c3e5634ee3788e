#include "sweep_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>

namespace s2nnds::program {
namespace {

std::string clock_text(double seconds) {
  const auto s = static_cast<long>(std::lround(seconds));
  return fmt::format("{:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string figure(double value) { return std::isnan(value) ? "none" : fmt::format("{:.4g}", value); }

}  // namespace

SweepProgress::SweepProgress(const Sweep& sweep, const std::vector<TrialResult>& before, std::size_t missing,
                             int jobs)
    : sweep_(sweep),
      terminal_(::isatty(::fileno(stderr)) == 1),
      jobs_(jobs),
      total_(before.size() + missing) {
  for (const TrialResult& result : before) take(result);
}

void SweepProgress::take(const TrialResult& result) {
  ++ended_;
  failed_ += result.failed ? 1 : 0;
  const double value = result.metric(sweep_.options.objective);
  if (!counts(sweep_.options, result) || !std::isfinite(value)) return;
  const double sign = sweep_.options.direction == "maximize" ? -1.0 : 1.0;
  if (!best_ || sign * value < sign * best_->metric(sweep_.options.objective)) best_ = result;
}

std::string SweepProgress::best_text() const {
  if (!best_) return "none";
  return fmt::format("{:.4g} (trial {})", best_->metric(sweep_.options.objective), best_->trial);
}

// From the trials that ended since this process started: all that is known of the speed of this machine.
std::string SweepProgress::left_text() const {
  if (ended_here_ == 0) return "unknown";
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  return clock_text(elapsed / static_cast<double>(ended_here_) * static_cast<double>(total_ - ended_));
}

void SweepProgress::clear() {
  if (terminal_) fmt::print(stderr, "\r\033[K");
}

void SweepProgress::ended(const TrialResult& result) {
  take(result);
  ++ended_here_;
  if (result.failed) {
    note(fmt::format("trial={} failed: {}", result.trial, result.error));
  } else if (!terminal_) {
    note(fmt::format("{}/{} trial={} guarantee={} {}={} seconds={:.1f} best={} failed={} left={}", ended_,
                     total_, result.trial, result.guarantee, sweep_.options.objective,
                     figure(result.metric(sweep_.options.objective)), result.seconds, best_text(), failed_,
                     left_text()));
  }
}

void SweepProgress::note(const std::string& line) {
  clear();
  fmt::print(stderr, "{}\n", line);
  std::fflush(stderr);
}

void SweepProgress::draw(std::size_t running) {
  if (!terminal_) return;
  clear();
  fmt::print(stderr, "{}/{} trials, {} running ({} at once), {} failed, best {} {}, left {}", ended_, total_,
             running, jobs_, failed_, sweep_.options.objective, best_text(), left_text());
  std::fflush(stderr);
}

void SweepProgress::finish() { clear(); }

}  // namespace s2nnds::program
