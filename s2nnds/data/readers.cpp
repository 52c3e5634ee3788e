// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/readers.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"
#include "s2nnds/data/file_patterns.h"
#include "s2nnds/data/handwriting.h"
#include "s2nnds/data/joint_angles.h"
#include "s2nnds/data/orientation_reading.h"
#include "s2nnds/data/recording.h"
#include "s2nnds/data/split.h"
#include "s2nnds/data/time_unit.h"

namespace s2nnds {
namespace {

// Slope at time t of the parabola through (t0, p0), (t1, p1), (t2, p2): the derivative of Newton's form.
Eigen::RowVectorXd slope(double t, double t0, double t1, double t2, const Eigen::RowVectorXd& p0,
                         const Eigen::RowVectorXd& p1, const Eigen::RowVectorXd& p2) {
  const Eigen::RowVectorXd first = (p1 - p0) / (t1 - t0);
  const Eigen::RowVectorXd second = ((p2 - p1) / (t2 - t1) - first) / (t2 - t0);
  return first + second * ((t - t0) + (t - t1));
}

std::string resolve(const std::string& file, const DataOptions& options, const std::string& data_dir) {
  check(!file.empty(), "data: found source '{}' without a file; expected one, relative to the data directory",
        options.source);
  const std::string path = (std::filesystem::path(data_dir) / file).string();
  std::error_code error;
  check(std::filesystem::exists(path, error),
        "{}: found no such file; expected it in the data directory '{}' (--data DIR or S2NNDS_DATA){}",
        printable(path), data_dir,
        options.source == "lasa" ? "; experiments/get_lasa.sh gets the LASA files" : "");
  return path;
}

RecordingSet as_recordings(const DemonstrationSet& set) {
  RecordingSet made{.name = set.name, .unit = set.unit, .time_unit = 1};
  for (const Demonstration& d : set.demonstrations)
    made.recordings.push_back({set.name, "", 0, d.time, d.position, d.velocity});
  return made;
}

// Of recordings that people made themselves: units may be wrong, samples may be lost.
bool is_raw(const std::string& source) {
  return source == "csv" || source == "npy" || source == "mat" || source == "hdf5";
}

RecordingSet read_hdf5_files(const std::vector<std::string>& paths, const TableOptions& options,
                             const ReadingProgress& progress) {
  check(!paths.empty(), "hdf5: found no files; expected at least one (data.files)");
  RecordingSet set = read_hdf5(paths.front(), options, progress);
  for (std::size_t i = 1; i < paths.size(); ++i) {
    for (Recording& r : read_hdf5(paths[i], options, progress).recordings)
      set.recordings.push_back(std::move(r));
  }
  return set;
}

RecordingSet read_raw(const DataOptions& options, const std::string& data_dir,
                      const ReadingProgress& progress) {
  const auto files = [&](const std::vector<std::string>& endings) {
    return find_data_files(options.files, data_dir, endings);
  };
  if (options.source == "csv") return read_csv(files({".csv", ".txt", ".tsv", ".dat"}), options, progress);
  if (options.source == "npy") return read_npy(files({".npy", ".npz"}), options);
  if (options.source == "mat") return read_mat(files({".mat"}), options);
  return read_hdf5_files(files({".h5", ".hdf5"}), options, progress);
}

RecordingSet read_source(const DataOptions& options, const std::string& data_dir,
                         const ReadingProgress& progress) {
  if (options.source == "handwriting") return as_recordings(handwriting(options.motion));
  if (is_raw(options.source)) {
    RecordingSet set = read_raw(options, data_dir, progress);
    if (!options.unit.empty()) set.unit = options.unit;
    return set;
  }
  const std::string path = resolve(options.file, options, data_dir);
  return options.source == "lasa" ? read_lasa(path) : read_ds_opt(path);
}

DemonstrationSet clean_all(const RecordingSet& recordings, const DataOptions& options,
                           const ReadingProgress& progress) {
  Eigen::Index since_tick = 0;
  DemonstrationSet set{recordings.name,
                       recordings.unit,
                       {},
                       recordings.report,
                       recordings.has_orientations,
                       recordings.quaternion_order};
  for (std::size_t k = 0; k < recordings.recordings.size(); ++k) {
    CleanDemonstration one =
        clean(recordings.recordings[k], options.cleaning, options.stride, recordings.unit);
    since_tick += recordings.recordings[k].samples();
    if (progress && since_tick >= samples_a_tick) {
      since_tick = 0;
      progress("cleaning " + recordings.recordings[k].where,
               static_cast<double>(k + 1) / static_cast<double>(recordings.recordings.size()));
    }
    set.demonstrations.push_back(std::move(one.demonstration));
    set.noise.push_back(one.noise);
    if (!one.steps.empty()) set.report.push_back(fmt::format("{}: {}", k, fmt::join(one.steps, ", ")));
  }
  return set;
}

// Rotation matrices have no order (that of policies is then xyzw), and HDF5 files as `s2nnds import` and robomimic
// write them have xyzw.
bool order_is_a_convention(const RecordingSet& recordings, const DataOptions& options) {
  return recordings.recordings.front().orientation.cols() == 9 ||
         (options.source == "hdf5" && options.columns.quaternion.empty());
}

// What the state asks for beyond positions.
void read_state(RecordingSet& recordings, const DataOptions& options) {
  if (!is_raw(options.source)) return;
  if (options.state == "joints") unwrap_joints(recordings);
  if (options.state != "pose") {
    recordings.quaternion_order.clear();
    return;
  }
  std::string& order = recordings.quaternion_order;
  check(order.empty() || options.quaternion_order == "auto" || order == options.quaternion_order,
        "data.quaternion_order: found {}, but the columns are named {}; expected one order",
        options.quaternion_order, order);
  if (options.quaternion_order != "auto") order = options.quaternion_order;
  if (order.empty() && order_is_a_convention(recordings, options)) order = "xyzw";
  check(!order.empty(),
        "{}: found quaternions and nothing that tells their order; expected data.quaternion_order = \"xyzw\" "
        "or "
        "\"wxyz\" (in the wrong one, angles stay as they are, and no check can see it)",
        recordings.recordings.front().where);
  make_unit_orientations(recordings, order);
}

}  // namespace

void DataOptions::visit(FieldVisitor& v) {
  v.field("source", source, {"handwriting", "lasa", "ds_opt", "csv", "npy", "mat", "hdf5"});
  if (source == "handwriting") {
    v.field("motion", motion, handwriting_motions());
  } else if (is_raw(source)) {
    v.field("files", files);
  } else {
    v.field("file", file);
  }
  if (source == "csv") v.field("delimiter", delimiter, {"auto", "comma", "semicolon", "tab", "blanks"});
  const std::vector<std::string> states = {"auto", "position", "phase", "pose", "joints"};
  v.field("state", state, {states.begin(), is_raw(source) ? states.end() : states.begin() + 3});
  if (is_raw(source)) {
    v.group("columns", columns);
    if (state == "pose") v.field("quaternion_order", quaternion_order, {"auto", "xyzw", "wxyz"});
    v.field("rate", rate, at_least(0));
    v.field("time_unit", time_unit, {"auto", "s", "ms", "us", "ns"});
    v.field("unit", unit);
    v.group("limits", limits);
  }
  v.group("cleaning", cleaning);
  v.field("stride", stride, at_least(1));
  v.field("goal", goal, {"mean", "each"});
  v.field("frame_name", frame_name);
  v.field("normalization", normalization, {"max_abs", "max_norm"});
  v.field("use", use, at_least(0));
  v.field("test", test, at_least(kTestByShare));
  v.field("validation", validation, at_least(0));
}

DemonstrationSet read_demonstrations(const DataOptions& options, const std::string& data_dir,
                                     const ReadingProgress& progress) {
  validate(options);
  RecordingSet recordings = read_source(options, data_dir, progress);
  if (!options.use.empty()) recordings.recordings = select(recordings.recordings, options.use);
  read_state(recordings, options);
  bring_to_seconds(recordings, options.time_unit);
  const bool cleaned =
      options.cleaning.steps == "auto" ? is_raw(options.source) : options.cleaning.steps == "on";
  DemonstrationSet set =
      cleaned ? clean_all(recordings, options, progress) : make_demonstrations(recordings, options.stride);
  check_demonstrations(set, set.name);
  if (is_raw(options.source)) {
    std::vector<std::string> time_columns;
    for (const Recording& r : recordings.recordings) time_columns.push_back(r.time_column);
    check_plausible(set, time_columns, options.limits);
  }
  return set;
}

Points differentiate(const Vector& time, const Points& position) {
  const Eigen::Index last = time.size() - 1;
  check(last >= 1 && position.rows() == time.size(),
        "differentiate: found {} times and {} positions; expected as many of each, at least 2", time.size(),
        position.rows());
  for (Eigen::Index i = 1; i <= last; ++i) {
    check(time[i] > time[i - 1],
          "differentiate: found time {} at sample {} after {}; expected increasing times", time[i], i,
          time[i - 1]);
  }
  Points velocity(position.rows(), position.cols());
  if (last == 1) {
    velocity.rowwise() = (position.row(1) - position.row(0)) / (time[1] - time[0]);
    return velocity;
  }
  for (Eigen::Index i = 0; i <= last; ++i) {
    const Eigen::Index m = std::clamp<Eigen::Index>(i, 1, last - 1);  // the middle one of the three samples
    velocity.row(i) = slope(time[i], time[m - 1], time[m], time[m + 1], position.row(m - 1), position.row(m),
                            position.row(m + 1));
  }
  return velocity;
}

std::string data_directory(const std::string& flag) {
  const char* environment = std::getenv("S2NNDS_DATA");
  const bool in_environment = environment != nullptr && *environment != '\0';
  const std::string given = !flag.empty() ? flag : in_environment ? environment : "";
  std::error_code error;
  if (!given.empty()) {
    check(std::filesystem::is_directory(given, error), "{}: found no such directory; expected {} to name one",
          given, flag.empty() ? "S2NNDS_DATA" : "--data");
    return given;
  }
  return std::filesystem::is_directory("../shared/data", error) ? "../shared/data" : "";
}

}  // namespace s2nnds
