// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "s2nnds/core/check.h"
#include "s2nnds/data/column_names.h"
#include "s2nnds/data/numpy_file.h"
#include "s2nnds/data/readers.h"

namespace s2nnds {
namespace {

using Arrays = std::vector<std::pair<std::string, Array>>;

// One [M, columns] of an array [M, columns] or [K, M, columns]; M numbers are one column.
Points part(const Array& array, Eigen::Index k) {
  const std::size_t rank = array.shape.size();
  const Eigen::Index rows = array.shape[rank == 3 ? 1 : 0];
  const Eigen::Index columns = rank == 1 ? 1 : array.shape.back();
  return Eigen::Map<const Points>(array.values.data() + (rank == 3 ? k * rows * columns : 0), rows, columns);
}

Eigen::Index parts(const Array& array) { return array.shape.size() == 3 ? array.shape[0] : 1; }

Vector counted(Eigen::Index samples, double rate) {
  return Vector::LinSpaced(samples, 0, static_cast<double>(samples - 1) / rate);
}

void read_table(const std::string& path, const Array& table, const TableOptions& options, RecordingSet& set) {
  const std::size_t rank = table.shape.size();
  check((rank == 2 || rank == 3) &&
            std::all_of(table.shape.begin(), table.shape.end(), [](auto n) { return n > 0; }),
        "{}: found shape [{}]; expected [M, columns] or [K, M, columns]", path, fmt::join(table.shape, ", "));
  std::vector<std::string> names;
  for (Eigen::Index i = 0; i < table.shape.back(); ++i) names.push_back(std::to_string(i));
  Columns columns = find_columns(names, false, options.rate <= 0, options.columns, path);
  set.has_orientations = !columns.orientation.empty();
  if (options.state != "pose") columns.orientation.clear();
  check(options.state != "pose" || !columns.orientation.empty(), "{}: {}", path, kNoOrientation);
  if (set.recordings.empty())
    set.report.push_back(fmt::format("columns of {}: {}", stem(path), describe(columns, names)));
  const auto as_places = [](const std::vector<std::size_t>& numbers) {
    return std::vector<Eigen::Index>(numbers.begin(), numbers.end());
  };
  for (Eigen::Index k = 0; k < parts(table); ++k) {
    const Points all = part(table, k);
    Recording r{rank == 3 ? fmt::format("{}: [{}]", path, k) : path,
                columns.time ? names[*columns.time] : "",
                0,
                {},
                all(Eigen::all, as_places(columns.position)),
                {}};
    if (columns.time) {
      r.time = all.col(static_cast<Eigen::Index>(*columns.time));
    } else {
      r.time = counted(all.rows(), options.rate);
    }
    if (!columns.velocity.empty()) r.velocity = all(Eigen::all, as_places(columns.velocity));
    if (!columns.orientation.empty()) r.orientation = all(Eigen::all, as_places(columns.orientation));
    set.recordings.push_back(std::move(r));
  }
}

class NamedArrays {
 public:
  NamedArrays(const std::string& path, const Arrays& arrays) : path_(path), arrays_(arrays) {}

  // The array of one of these names, or null; the first name that is there counts.
  const Array* any(const std::vector<std::string>& names) const {
    for (const std::string& name : names) {
      for (const auto& [found, array] : arrays_)
        if (found == name) return &array;
    }
    return nullptr;
  }
  const Array& wanted(const std::vector<std::string>& names, std::string_view key) const {
    const Array* const array = any(names);
    std::vector<std::string> all;
    for (const auto& [name, each] : arrays_) all.push_back(fmt::format("'{}'", name));
    check(array != nullptr, "{}: found the arrays {}; expected '{}' (data.columns.{} names another)", path_,
          fmt::join(all, ", "), names.front(), key);
    return *array;
  }

 private:
  const std::string& path_;
  const Arrays& arrays_;
};

void check_shape(const Array& array, const Array& position, std::string_view what, const std::string& path) {
  check(array.shape == position.shape,
        "{}: found {} of shape [{}] for positions [{}]; expected the same shape", path, what,
        fmt::join(array.shape, ", "), fmt::join(position.shape, ", "));
}

// Quaternions [M, 4] or [K, M, 4], or rotation matrices [M, 9], [M, 3, 3] or [K, M, 3, 3], as rows of 4 or 9 like the
// positions; null where nothing of the kind is there.
std::optional<Array> orientations_of(const NamedArrays& named, const Array& position,
                                     const ColumnOptions& wanted, const std::string& path) {
  check(wanted.quaternion.size() + wanted.rotation.size() <= 1,
        "{}: found {} arrays of orientations; expected one (data.columns.quaternion or rotation)", path,
        wanted.quaternion.size() + wanted.rotation.size());
  const Array* const found = !wanted.rotation.empty() ? &named.wanted(wanted.rotation, "rotation")
                             : !wanted.quaternion.empty()
                                 ? &named.wanted(wanted.quaternion, "quaternion")
                                 : named.any({"quaternion", "orientation", "rotation"});
  if (found == nullptr) return std::nullopt;
  Array rows = *found;
  if (rows.shape.size() >= 3 && rows.shape.back() == 3 && rows.shape[rows.shape.size() - 2] == 3) {
    rows.shape.pop_back();
    rows.shape.back() = 9;
  }
  std::vector<Eigen::Index> expected = position.shape;
  expected.back() = rows.shape.back();
  check(rows.shape == expected && (expected.back() == 4 || expected.back() == 9),
        "{}: found orientations of shape [{}] for positions [{}]; expected one a sample, 4 numbers or 3 x 3",
        path, fmt::join(found->shape, ", "), fmt::join(position.shape, ", "));
  return rows;
}

void read_arrays(const std::string& path, const Arrays& arrays, const TableOptions& options,
                 RecordingSet& set) {
  const ColumnOptions& wanted = options.columns;
  const NamedArrays named(path, arrays);
  check(wanted.position.size() <= 1 && wanted.velocity.size() <= 1,
        "{}: found {} arrays of positions; expected one of [M, n] (data.columns.position)", path,
        wanted.position.size());
  const Array& position = wanted.position.empty()
                              ? named.wanted({"position", "positions", "pos", "x", "xyz", "q"}, "position")
                              : named.wanted(wanted.position, "position");
  const std::size_t rank = position.shape.size();
  check(rank == 2 || rank == 3, "{}: found positions of shape [{}]; expected [M, n] or [K, M, n]", path,
        fmt::join(position.shape, ", "));
  const Array* time = nullptr;
  if (options.rate <= 0) {
    time = &(wanted.time.empty() ? named.wanted({"time", "t", "times", "timestamps"}, "time")
                                 : named.wanted({wanted.time}, "time"));
    const std::size_t time_rank = time->shape.size();
    const bool for_each = rank == 3 && time_rank == 2;
    check((time_rank == 1 && time->shape[0] == position.shape[rank - 2]) ||
              (for_each && time->shape[0] == position.shape[0] && time->shape[1] == position.shape[1]),
          "{}: found times of shape [{}] for positions [{}]; expected one time a sample", path,
          fmt::join(time->shape, ", "), fmt::join(position.shape, ", "));
  }
  const Array* velocity = wanted.velocity.empty()        ? named.any({"velocity", "velocities", "vel"})
                          : wanted.velocity[0] == "none" ? nullptr
                                                         : &named.wanted(wanted.velocity, "velocity");
  if (velocity != nullptr) check_shape(*velocity, position, "velocities", path);
  const std::optional<Array> orientation = orientations_of(named, position, wanted, path);
  check(options.state != "pose" || orientation, "{}: {}", path, kNoOrientation);
  set.has_orientations = orientation.has_value();
  for (Eigen::Index k = 0; k < parts(position); ++k) {
    Recording r{rank == 3 ? fmt::format("{}: [{}]", path, k) : path,
                time != nullptr ? "time" : "",
                0,
                {},
                part(position, k),
                {}};
    const Eigen::Index samples = r.position.rows();
    if (time == nullptr) {
      r.time = counted(samples, options.rate);
    } else {
      r.time = Eigen::Map<const Vector>(time->values.data() + (time->shape.size() == 2 ? k * samples : 0),
                                        samples);
    }
    if (velocity != nullptr) r.velocity = part(*velocity, k);
    if (options.state == "pose") r.orientation = part(*orientation, k);
    set.recordings.push_back(std::move(r));
  }
}

}  // namespace

RecordingSet read_npy(const std::vector<std::string>& paths, const TableOptions& options) {
  check(!paths.empty(), "npy: found no files; expected at least one (data.files)");
  RecordingSet set{stem(paths.front()), ""};
  if (options.rate > 0) set.time_unit = 1;
  for (const std::string& path : paths) {
    const Arrays arrays = read_numpy_file(path);
    if (arrays.size() == 1 && arrays.front().first.empty()) {
      read_table(path, arrays.front().second, options, set);
    } else {
      read_arrays(path, arrays, options, set);
    }
    const Eigen::Index n = set.recordings.back().position.cols(),
                       first = set.recordings.front().position.cols();
    check(n == first, "{}: found {} position columns; expected {} as in {}", path, n, first, paths.front());
  }
  return set;
}

}  // namespace s2nnds
