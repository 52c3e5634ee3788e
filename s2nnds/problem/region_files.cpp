// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/region_files.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"

namespace s2nnds {
namespace {

std::optional<std::string> read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open() || std::filesystem::is_directory(path)) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

}  // namespace

const std::string& RegionFiles::bytes(const std::string& name) {
  if (const auto known = bytes_.find(name); known != bytes_.end()) return known->second;
  check(folder_.has_value(), "file {}: the run does not have it, expected it to be stored there",
        printable(name));
  const std::filesystem::path path = std::filesystem::path(*folder_) / name;
  std::error_code none;
  check(!std::filesystem::is_directory(path, none), "cannot read {}: expected a file, found a folder",
        printable(path.string()));
  std::optional<std::string> read = read_file(path);
  if (!read) fail("cannot read {}: {}", printable(path.string()), std::strerror(errno));
  check(!read->empty(), "{}: expected a file that says something, found an empty one",
        printable(path.string()));
  return bytes_.emplace(name, std::move(*read)).first->second;
}

std::vector<std::string> RegionFiles::changed_in(const std::string& folder) const {
  std::vector<std::string> changed;
  for (const auto& [name, bytes] : bytes_) {
    const std::optional<std::string> there = read_file(std::filesystem::path(folder) / name);
    if (there && *there != bytes) changed.push_back(name);
  }
  return changed;
}

}  // namespace s2nnds
