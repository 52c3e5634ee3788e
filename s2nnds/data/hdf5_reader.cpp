// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/core/hdf5.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/data/recording.h"

namespace s2nnds {
namespace {

constexpr std::string_view kExpected =
    "/demonstrations/K with time [M], position [M, n] and, optionally, velocity [M, n]";

// Numbers of rank 1 or 2 as [rows, columns]; rank 1 counts as one column.
Points read_matrix(const Hdf5Reader& file, const std::string& item) {
  const Array array = file.read<Array>(item);
  const std::size_t rank = array.shape.size();
  check(rank == 1 || rank == 2, "{}: {}: found rank {}; expected {}", file.path(), item, rank, kExpected);
  return Eigen::Map<const Points>(array.values.data(), array.shape[0], rank == 2 ? array.shape[1] : 1);
}

Recording read_recording(const Hdf5Reader& file, const std::string& group) {
  const Points time = read_matrix(file, group + "/time");
  check(time.rows() == 1 || time.cols() == 1, "{}: {}/time: found shape [{}, {}]; expected {}", file.path(),
        group, time.rows(), time.cols(), kExpected);
  const Points position = read_matrix(file, group + "/position");
  const bool has_velocity = file.exists(group + "/velocity");
  const Points velocity = has_velocity ? read_matrix(file, group + "/velocity") : Points();
  return {fmt::format("{}: {}", file.path(), group),          "time",   0,
          Eigen::Map<const Vector>(time.data(), time.size()), position, velocity};
}

}  // namespace

RecordingSet read_hdf5(const std::string& path) {
  check_readable(path);
  const Hdf5Reader file(path);
  std::vector<std::string> names = file.children("/demonstrations");
  std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {  // 2 before 10
    return std::pair(a.size(), a) < std::pair(b.size(), b);
  });
  RecordingSet set{stem(path), ""};
  for (const std::string& name : names) {
    set.recordings.push_back(read_recording(file, "/demonstrations/" + name));
  }
  return set;
}

}  // namespace s2nnds
