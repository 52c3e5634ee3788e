// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/region_files.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"

namespace s2nnds {
namespace {

constexpr std::size_t kMostBytes = 64'000'000;  // of one file

// Reads little more than files may have: devices have no end.
std::optional<std::string> read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open() || std::filesystem::is_directory(path)) return std::nullopt;
  std::string bytes;
  std::array<char, 65536> part{};
  while (file && bytes.size() <= kMostBytes) {
    file.read(part.data(), part.size());
    bytes.append(part.data(), static_cast<std::size_t>(file.gcount()));
  }
  return bytes;
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
  check(read->size() <= kMostBytes,
        "{}: found more than {} MB, expected at most that, because runs keep the file; thin it out",
        printable(path.string()), kMostBytes / 1'000'000);
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
