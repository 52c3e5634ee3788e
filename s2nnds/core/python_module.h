// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace s2nnds {

// The folder of the Python package s2nnds, which also holds the program s2nnds: in a build tree, below an install
// prefix and in a wheel alike. It is found from this code alone, which is part of that program, of a library in the
// same folder, or of a program beside a link to it. Throws Error where there is none.
std::string python_package();

// The Python to start: the one that the environment variable S2NNDS_PYTHON names, else /usr/bin/python3.
std::string python_program();

// Runs the module s2nnds.NAME of that package, `python -m s2nnds.NAME ARGUMENTS`, with python_program(), and returns
// its exit code (1: a signal ended it). `command` names who asks in the Error that is thrown when it cannot be started.
int run_python_module(const std::string& command, const std::string& name,
                      const std::vector<std::string>& arguments);

}  // namespace s2nnds
