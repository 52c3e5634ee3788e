// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace s2nnds {

// Replaces the file at `path` whole or not at all: writes `bytes` beside it, flushes them to the disk and
// renames, so that a crash or a full disk leaves the old file or the new one. Several processes and threads
// may write the same path; the last one wins. Throws Error "PATH: cannot write WHAT: reason".
void write_atomic_file(const std::string& path, const std::string& bytes, const std::string& what);

}  // namespace s2nnds
