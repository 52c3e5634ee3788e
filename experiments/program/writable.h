// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace s2nnds::program {

// Throws Error unless a file can be written at `path`: found out before hours of training are lost.
void check_writable(const std::string& path);

}  // namespace s2nnds::program
