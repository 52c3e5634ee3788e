// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/core/hdf5.h"
#include "s2nnds/core/options.h"

namespace s2nnds {

namespace options_detail {
void write_fields(Hdf5Writer& file, const std::string& group, const Visit& visit);
void read_fields(const Hdf5Reader& file, const std::string& group, const Visit& visit);
}  // namespace options_detail

// Structs that name their fields in visit() as HDF5: one attribute of `group` a field (truth values as the
// integers 0 and 1), a sub-group for a group, and for a list of structs a sub-group with a group 0, 1, ... an
// element.
template <typename T>
void write_fields(Hdf5Writer& file, const std::string& group, T fields) {
  options_detail::write_fields(file, group, [&](FieldVisitor& v) { fields.visit(v); });
}

// Reads what write_fields wrote into `group`. Throws Error naming the file and the attribute that is missing
// or of another type.
template <typename T>
T read_fields(const Hdf5Reader& file, const std::string& group) {
  T fields;
  options_detail::read_fields(file, group, [&](FieldVisitor& v) { fields.visit(v); });
  return fields;
}

}  // namespace s2nnds
