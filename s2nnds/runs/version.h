// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace s2nnds {

std::string program_version();   // "0.1.0"
std::string build_type();        // "Release"
std::string library_versions();  // "LibTorch 1.13.1, HDF5 1.10.8, Eigen 3.4.0, ..."

}  // namespace s2nnds
