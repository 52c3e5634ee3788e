// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/core/hdf5.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/data/recording.h"

namespace s2nnds {
namespace {

constexpr std::string_view kOurGroup = "/demonstrations";
constexpr std::string_view kRobomimicGroup = "/data";
constexpr std::string_view kRobomimicPosition = "obs/robot0_eef_pos";
constexpr std::string_view kRobomimicQuaternion = "obs/robot0_eef_quat";  // xyzw

// Numbers of rank 1 or 2 as [rows, columns]; rank 1 counts as one column.
Points read_matrix(const Hdf5Reader& file, const std::string& item) {
  const Array array = file.read<Array>(item);
  const std::size_t rank = array.shape.size();
  check(rank == 1 || rank == 2, "{}: {}: found rank {}; expected [M] or [M, n]", file.path(), item, rank);
  return Eigen::Map<const Points>(array.values.data(), array.shape[0], rank == 2 ? array.shape[1] : 1);
}

// The data sets side by side.
Points read_matrices(const Hdf5Reader& file, const std::string& group,
                     const std::vector<std::string>& items) {
  Points all;
  for (const std::string& item : items) {
    const Points one = read_matrix(file, group + "/" + item);
    check(all.size() == 0 || all.rows() == one.rows(), "{}: {}/{}: found {} rows; expected {} as in '{}'",
          file.path(), group, item, one.rows(), all.rows(), items.front());
    const Eigen::Index before = all.cols();
    all.conservativeResize(one.rows(), before + one.cols());
    all.rightCols(one.cols()) = one;
  }
  return all;
}

// What robomimic says of its simulation, in JSON: env_args, with the steps per second. 0: nothing.
double control_frequency(const Hdf5Reader& file) {
  if (!file.has_attribute(std::string(kRobomimicGroup), "env_args")) return 0;
  const auto said =
      nlohmann::json::parse(file.text_attribute(std::string(kRobomimicGroup), "env_args"), nullptr, false);
  if (!said.is_object() || !said.contains("env_kwargs") || !said["env_kwargs"].is_object()) return 0;
  const auto& arguments = said["env_kwargs"];
  return arguments.contains("control_freq") && arguments["control_freq"].is_number()
             ? arguments["control_freq"].get<double>()
             : 0;
}

// Where the parts of each demonstration lie in a file.
struct Layout {
  std::string group;
  std::string time;  // "": counted by `rate`
  std::vector<std::string> position;
  std::vector<std::string> velocity;     // those that are there are read
  std::vector<std::string> orientation;  // of quaternions or rotation matrices
  double rate = 0;
  bool robomimic = false;
};

Layout find_layout(const Hdf5Reader& file, const TableOptions& options) {
  const ColumnOptions& wanted = options.columns;
  Layout layout{wanted.index, wanted.time, wanted.position, wanted.velocity, {}, options.rate};
  layout.orientation = wanted.rotation.empty() ? wanted.quaternion : wanted.rotation;
  if (layout.group.empty()) {
    const bool ours = file.exists(std::string(kOurGroup)) || !file.exists(std::string(kRobomimicGroup));
    layout.group = ours ? kOurGroup : kRobomimicGroup;
  }
  if (!layout.group.starts_with("/")) layout.group = "/" + layout.group;
  while (layout.group.ends_with("/")) layout.group.pop_back();
  layout.robomimic = layout.group == kRobomimicGroup && wanted.time.empty();
  if (layout.position.empty())
    layout.position = {layout.robomimic ? std::string(kRobomimicPosition) : "position"};
  if (layout.orientation.empty())
    layout.orientation = {layout.robomimic ? std::string(kRobomimicQuaternion) : "orientation"};
  if (layout.velocity.empty() && wanted.position.empty()) layout.velocity = {"velocity"};
  if (layout.velocity == std::vector<std::string>{"none"}) layout.velocity.clear();
  if (layout.robomimic && layout.rate <= 0) layout.rate = control_frequency(file);
  if (layout.rate <= 0 && layout.time.empty()) layout.time = "time";
  return layout;
}

// Rotation matrices [M, 3, 3] are rows of 9.
Points read_orientations(const Hdf5Reader& file, const std::string& group, const Layout& layout) {
  if (layout.orientation.size() == 1) {
    const std::string item = group + "/" + layout.orientation.front();
    const Array array = file.read<Array>(item);
    if (array.shape.size() == 3 && array.shape[1] == 3 && array.shape[2] == 3)
      return Eigen::Map<const Points>(array.values.data(), array.shape[0], 9);
  }
  return read_matrices(file, group, layout.orientation);
}

Recording read_recording(const Hdf5Reader& file, const std::string& group, const Layout& layout) {
  Recording r{fmt::format("{}: {}", file.path(), group), layout.time, 0, {}, {}, {}};
  if (!layout.time.empty()) {
    check(!layout.robomimic || file.exists(group + "/" + layout.time),
          "{}: found no times in {} and no control frequency; expected data.rate (samples per second)",
          file.path(), group);
    const Points time = read_matrix(file, group + "/" + layout.time);
    check(time.rows() == 1 || time.cols() == 1, "{}: {}/{}: found shape [{}, {}]; expected one time a sample",
          file.path(), group, layout.time, time.rows(), time.cols());
    r.time = Eigen::Map<const Vector>(time.data(), time.size());
  }
  r.position = read_matrices(file, group, layout.position);
  if (layout.time.empty())
    r.time = Vector::LinSpaced(r.samples(), 0, static_cast<double>(r.samples() - 1) / layout.rate);
  const bool has_velocity = !layout.velocity.empty() && file.exists(group + "/" + layout.velocity.front());
  if (has_velocity) r.velocity = read_matrices(file, group, layout.velocity);
  return r;
}

}  // namespace

RecordingSet read_hdf5(const std::string& path, const TableOptions& options,
                       const ReadingProgress& progress) {
  check_readable(path);
  const Hdf5Reader file(path);
  const Layout layout = find_layout(file, options);
  std::vector<std::string> names = file.children(layout.group.empty() ? "/" : layout.group);
  std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {  // 2 before 10
    return std::pair(a.size(), a) < std::pair(b.size(), b);
  });
  RecordingSet set{stem(path), ""};
  check(!names.empty(), "{}: found no demonstrations in {}; expected at least 1", path, layout.group);
  Eigen::Index since_tick = 0;
  for (const std::string& name : names) {
    const std::string group = layout.group + "/" + name;
    set.recordings.push_back(read_recording(file, group, layout));
    const bool has_orientation = file.exists(group + "/" + layout.orientation.front());
    check(options.state != "pose" || has_orientation, "{}: {}: {}", path, group, kNoOrientation);
    set.has_orientations = set.has_orientations || has_orientation;
    if (options.state == "pose") set.recordings.back().orientation = read_orientations(file, group, layout);
    since_tick += set.recordings.back().samples();
    if (!progress || since_tick < samples_a_tick) continue;
    since_tick = 0;
    progress("reading " + path,
             static_cast<double>(set.recordings.size()) / static_cast<double>(names.size()));
  }
  if (layout.time.empty()) set.time_unit = 1;
  if (file.has_attribute(layout.group, "unit")) set.unit = file.text_attribute(layout.group, "unit");
  if (layout.group != kOurGroup || !options.columns.position.empty()) {
    set.report.push_back(
        fmt::format("{} demonstrations in {}: position {}, time {}", names.size(), layout.group,
                    fmt::join(layout.position, " "),
                    layout.time.empty() ? fmt::format("by {:g} samples/s", layout.rate) : layout.time));
  }
  return set;
}

}  // namespace s2nnds
