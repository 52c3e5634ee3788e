// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace s2nnds::fuzz {

// Changes the HDF5 file at `path` as the input says: removes groups, datasets and attributes, and puts others of
// any small shape and type in their place. The file stays sound: HDF5 itself crashes on some that are not, which
// no reader can help.
void edit_hdf5(const std::string& path, const std::uint8_t* data, std::size_t size);

}  // namespace s2nnds::fuzz
