// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace s2nnds {

// A file's SHA-256, as a line of text after its last byte, so that damage is noticed before anything reads what
// is damaged. HDF5 does not look at what stands behind a file's end, and drops it when another program writes
// to the file.

// `bytes` with the line.
std::string with_digest(std::string bytes);

// `bytes` without the line, if it is there. Throws Error starting with `path` when the line is cut or is not
// that of the bytes.
std::string without_digest(std::string bytes, const std::string& path);

}  // namespace s2nnds
