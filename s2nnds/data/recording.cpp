// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/recording.h"

#include <filesystem>
#include <fstream>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/data/readers.h"

namespace s2nnds {
namespace {

std::vector<Eigen::Index> kept_samples(Eigen::Index samples, std::int64_t stride) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < samples; i += stride) kept.push_back(i);
  if (kept.back() != samples - 1) kept.push_back(samples - 1);  // the last position is the goal
  return kept;
}

void check_finite(const Recording& r, Eigen::Index i) {
  const bool time = std::isfinite(r.time[i]);
  const bool position = r.position.row(i).allFinite();
  const bool orientation = r.orientation.size() == 0 || r.orientation.row(i).allFinite();
  const bool velocity = r.velocity.size() == 0 || r.velocity.row(i).allFinite();
  if (time && position && orientation && velocity) return;
  fail(
      "{}: found a {} that is NaN, infinite or missing; expected finite numbers (data.cleaning.missing drops "
      "such samples)",
      r.place(i),
      !time          ? "time"
      : !position    ? "position"
      : !orientation ? "orientation"
                     : "velocity");
}

}  // namespace

std::string Recording::place(Eigen::Index i) const {
  if (lines.empty()) return fmt::format("{}: sample {}", where, i);
  return fmt::format("{}:{}", where, lines[static_cast<std::size_t>(i)]);
}

Recording Recording::at(const std::vector<Eigen::Index>& samples) const {
  Recording part{where, time_column, time_offset, time(samples), position(samples, Eigen::all), {}};
  if (velocity.size() > 0) part.velocity = velocity(samples, Eigen::all);
  if (orientation.size() > 0) part.orientation = orientation(samples, Eigen::all);
  if (lines.empty()) return part;
  for (const Eigen::Index i : samples) part.lines.push_back(lines[static_cast<std::size_t>(i)]);
  return part;
}

void check_recording(const Recording& r) {
  const Eigen::Index n = r.position.cols();
  check(n >= 2, "{}: found dimension {}; expected at least 2", r.where, n);
  check(r.samples() >= 2, "{}: found {} sample(s); expected at least 2", r.where, r.samples());
  check(r.time.size() == r.samples(), "{}: found {} times for {} positions; expected one each", r.where,
        r.time.size(), r.samples());
  check(r.velocity.size() == 0 || (r.velocity.rows() == r.samples() && r.velocity.cols() == n),
        "{}: found velocities [{}, {}]; expected [{}, {}] as the positions", r.where, r.velocity.rows(),
        r.velocity.cols(), r.samples(), n);
  check(r.orientation.size() == 0 || (r.orientation.rows() == r.samples() && r.orientation.cols() == 4),
        "{}: found orientations [{}, {}]; expected [{}, 4]", r.where, r.orientation.rows(),
        r.orientation.cols(), r.samples());
  for (Eigen::Index i = 0; i < r.samples(); ++i) {
    check_finite(r, i);
    if (i == 0) continue;
    if (r.time[i] > r.time[i - 1]) continue;
    fail(
        "{}: found time {} after {}; expected increasing times (data.cleaning.repeated_times merges repeated "
        "and sorts exchanged ones)",
        r.place(i), r.time_offset + r.time[i], r.time_offset + r.time[i - 1]);
  }
}

Demonstration make_demonstration(const Recording& r, std::int64_t stride) {
  check(stride >= 1, "stride: found {}; expected >= 1", stride);
  check_recording(r);
  const std::vector<Eigen::Index> kept = kept_samples(r.samples(), stride);
  Demonstration thin{r.time(kept), r.position(kept, Eigen::all), {}};
  if (r.velocity.size() > 0) {
    thin.velocity = r.velocity(kept, Eigen::all);
  } else {
    thin.velocity = differentiate(thin.time, thin.position);
  }
  if (r.orientation.size() > 0) thin.orientation = r.orientation(kept, Eigen::all);
  if (r.lines.empty()) return thin;
  for (const Eigen::Index i : kept) thin.lines.push_back(r.lines[static_cast<std::size_t>(i)]);
  return thin;
}

DemonstrationSet make_demonstrations(const RecordingSet& set, std::int64_t stride) {
  DemonstrationSet made{set.name, set.unit, {}, set.report, set.has_orientations, set.quaternion_order};
  for (const Recording& recording : set.recordings)
    made.demonstrations.push_back(make_demonstration(recording, stride));
  return made;
}

void check_readable(const std::string& path) {
  std::error_code error;
  check(std::filesystem::exists(path, error), "{}: found no such file; expected a file that can be read",
        path);
  check(!std::filesystem::is_directory(path, error), "{}: found a directory; expected a file", path);
  check(std::ifstream(path).good(), "{}: cannot be opened; expected a file that can be read", path);
}

std::string stem(const std::string& path) { return std::filesystem::path(path).stem().string(); }

}  // namespace s2nnds
