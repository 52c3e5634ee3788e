// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace s2nnds::program {

// Runs a script with the Python of S2NNDS_PYTHON, else Debian's, and returns its exit code. `command` names
// who asks.
int run_python(const std::string& command, const std::string& script,
               const std::vector<std::string>& arguments);

}  // namespace s2nnds::program
