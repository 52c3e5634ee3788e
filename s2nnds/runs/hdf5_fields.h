#pragma once

#include <string>

#include "s2nnds/core/options.h"
#include "s2nnds/runs/hdf5_file.h"

namespace s2nnds {

// Structs that name their fields in visit() as HDF5: one attribute of `group` a field (truth values as the
// integers 0 and 1), a sub-group for a group, and for a list of structs a sub-group with a group 0, 1, ... an
// element.
void write_fields(Hdf5Writer& file, const std::string& group, options_detail::AnyOptions& fields);
// Throws Error naming the file and the attribute that is missing or of another type.
void read_fields(const Hdf5Reader& file, const std::string& group, options_detail::AnyOptions& fields);

template <typename T>
void write_fields(Hdf5Writer& file, const std::string& group, T fields) {
  options_detail::Wrapped<T> wrapped(fields);
  write_fields(file, group, static_cast<options_detail::AnyOptions&>(wrapped));
}

template <typename T>
T read_fields(const Hdf5Reader& file, const std::string& group) {
  T fields;
  options_detail::Wrapped<T> wrapped(fields);
  read_fields(file, group, wrapped);
  return fields;
}

}  // namespace s2nnds
