// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/file_patterns.h"

#include <fmt/ranges.h>
#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <functional>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"

namespace s2nnds {
namespace {

namespace fs = std::filesystem;

// Whether a stands before b, with numbers by value.
bool naturally_before(const std::string& a, const std::string& b) {
  const auto digits = [](const std::string& text, std::size_t from) {
    std::size_t end = from;
    while (end < text.size() && std::isdigit(static_cast<unsigned char>(text[end]))) ++end;
    return end - from;
  };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const std::size_t first = digits(a, i), second = digits(b, j);
    if (first > 0 && second > 0) {
      const std::string x = a.substr(i, first), y = b.substr(j, second);
      const auto value = [](const std::string& text) {
        return text.substr(std::min(text.find_first_not_of('0'), text.size()));
      };
      if (value(x) != value(y)) {
        return value(x).size() != value(y).size() ? value(x).size() < value(y).size() : value(x) < value(y);
      }
      i += first;
      j += second;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if ((i < a.size()) != (j < b.size())) return j < b.size();
  return a < b;
}

bool is_pattern(const std::string& name) { return name.find_first_of("*?[") != std::string::npos; }

std::vector<std::string> files_in(const fs::path& folder, const std::function<bool(const fs::path&)>& wanted,
                                  const std::string& what) {
  std::error_code error;
  std::vector<std::string> files;
  check(fs::is_directory(folder, error), "{}: found no such folder; expected one with data files",
        printable(folder.string()));
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(error) && wanted(entry.path().filename()))
      files.push_back(entry.path().string());
  check(!files.empty(), "{}: found no files {}; expected at least one (data.files)",
        printable(folder.string()), what);
  std::sort(files.begin(), files.end(), naturally_before);
  return files;
}

std::vector<std::string> files_of(const std::string& pattern, const std::string& folder,
                                  const std::vector<std::string>& endings) {
  const fs::path path = fs::path(folder) / pattern;
  std::error_code error;
  if (fs::is_directory(path, error)) {
    const auto has_ending = [&](const fs::path& file) {
      return std::find(endings.begin(), endings.end(), file.extension().string()) != endings.end();
    };
    return files_in(path, has_ending, fmt::format("that end in {}", fmt::join(endings, ", ")));
  }
  if (fs::exists(path, error)) return {path.string()};
  check(is_pattern(path.filename().string()),
        "{}: found no such file; expected it in the data directory '{}' (--data DIR or S2NNDS_DATA)",
        printable(path.string()), folder);
  const std::string names = path.filename().string();
  return files_in(
      path.parent_path(),
      [&](const fs::path& file) { return fnmatch(names.c_str(), file.c_str(), FNM_PERIOD) == 0; },
      fmt::format("as '{}'", printable(names, 200)));
}

}  // namespace

std::vector<std::string> find_data_files(const std::vector<std::string>& patterns, const std::string& folder,
                                         const std::vector<std::string>& endings) {
  std::vector<std::string> files;
  for (const std::string& pattern : patterns) {
    const std::vector<std::string> found = files_of(pattern, folder, endings);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

}  // namespace s2nnds
