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

}  // namespace

Demonstration make_demonstration(const Vector& time, const Points& position, const Points& velocity,
                                 std::int64_t stride, const std::string& where) {
  check(stride >= 1, "stride: found {}; expected >= 1", stride);
  const bool recorded = velocity.size() > 0;
  const Demonstration raw{time, position,
                          recorded ? velocity : Points(Points::Zero(position.rows(), position.cols()))};
  check_demonstration(raw, where);
  const std::vector<Eigen::Index> kept = kept_samples(raw.samples(), stride);
  Demonstration thin{raw.time(kept), raw.position(kept, Eigen::all), raw.velocity(kept, Eigen::all)};
  if (!recorded) thin.velocity = differentiate(thin.time, thin.position);
  return thin;
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
