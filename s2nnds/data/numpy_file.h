// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "s2nnds/core/hdf5.h"

namespace s2nnds {

// The array in the bytes of an .npy file (format 1.0 to 3.0): real numbers of 4 or 8 bytes and integers of 1 to
// 8, of either byte order, in C or Fortran order; here the last index runs fastest. Throws Error starting with
// `where` for another format, another type, and bytes that are missing or too many.
Array parse_npy(const std::string& bytes, const std::string& where);

// The arrays of an .npy file (one, named "") or an .npz file (each with its name, without ".npy"), in the
// file's order. Throws Error naming file and array.
std::vector<std::pair<std::string, Array>> read_numpy_file(const std::string& path);

}  // namespace s2nnds
