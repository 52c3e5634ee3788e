// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/readers.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "s2nnds/core/check.h"
#include "s2nnds/data/handwriting.h"
#include "s2nnds/data/recording.h"
#include "s2nnds/data/split.h"

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
        "{}: found no such file; expected it in the data directory '{}' (--data DIR or S2NNDS_DATA){}", path,
        data_dir, options.source == "lasa" ? "; experiments/get_lasa.sh gets the LASA files" : "");
  return path;
}

Demonstration thinned(const Demonstration& d, std::int64_t stride, const std::string& name) {
  return make_demonstration(d.time, d.position, d.velocity, stride, name);
}

DemonstrationSet read_source(const DataOptions& options, const std::string& data_dir) {
  if (options.source == "handwriting") {
    DemonstrationSet set = handwriting(options.motion);
    for (Demonstration& d : set.demonstrations) d = thinned(d, options.stride, set.name);
    return set;
  }
  if (options.source == "csv") {
    std::vector<std::string> paths;
    for (const std::string& file : options.files) paths.push_back(resolve(file, options, data_dir));
    DemonstrationSet set = read_csv(paths, options.stride);
    set.unit = options.unit;
    return set;
  }
  const std::string path = resolve(options.file, options, data_dir);
  if (options.source == "lasa") return read_lasa(path, options.stride);
  if (options.source == "ds_opt") return read_ds_opt(path, options.stride);
  DemonstrationSet set = read_hdf5(path, options.stride);
  set.unit = options.unit;
  return set;
}

}  // namespace

void DataOptions::visit(FieldVisitor& v) {
  v.field("source", source, {"handwriting", "lasa", "ds_opt", "csv", "hdf5"});
  if (source == "handwriting") {
    v.field("motion", motion, handwriting_motions());
  } else if (source == "csv") {
    v.field("files", files);
  } else {
    v.field("file", file);
  }
  if (source == "csv" || source == "hdf5") v.field("unit", unit);
  v.field("stride", stride, at_least(1));
  v.field("normalization", normalization, {"max_abs", "max_norm"});
  v.field("use", use, at_least(0));
  v.field("test", test, at_least(0));
  v.field("validation", validation, at_least(0));
}

DemonstrationSet read_demonstrations(const DataOptions& options, const std::string& data_dir) {
  validate(options);
  DemonstrationSet set = read_source(options, data_dir);
  if (!options.use.empty()) set.demonstrations = select(set.demonstrations, options.use);
  check_demonstrations(set, set.name);
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
