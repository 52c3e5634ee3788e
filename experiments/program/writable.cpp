// SPDX-License-Identifier: BSD-3-Clause
#include "writable.h"

#include <unistd.h>

#include <filesystem>

#include "s2nnds/core/check.h"

namespace s2nnds::program {

namespace fs = std::filesystem;

void check_writable(const std::string& path) {
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  check(fs::is_directory(folder), "{}: cannot write it: {} is not a directory", path, folder.string());
  check(::access(folder.c_str(), W_OK) == 0, "{}: cannot write it: no permission to write into {}", path,
        folder.string());
  check(!fs::is_directory(path), "{}: cannot write it: it is a directory", path);
}

}  // namespace s2nnds::program
