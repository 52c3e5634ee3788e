#pragma once

#include <string>

namespace s2nnds {

// Writes `bytes` beside `path` and renames, so that a crash or a full disk leaves the older file or the new
// one. Throws Error "PATH: cannot write WHAT: reason".
void write_atomic_file(const std::string& path, const std::string& bytes, const std::string& what);

}  // namespace s2nnds
