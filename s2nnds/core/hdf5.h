// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/core/points.h"

namespace s2nnds {

std::string hdf5_version();  // of the HDF5 library in use: "1.10.8"

// Numbers of any shape, the last index running fastest.
struct Array {
  std::vector<Eigen::Index> shape;  // empty: a single value
  std::vector<double> values;       // as many as the product of `shape`
};

// What a dataset or an attribute is to hold: a view of a value that must outlive it. Every type that can be
// stored converts to it.
class Hdf5Value {
 public:
  Hdf5Value(const double& value);                     // NOLINT: one number
  Hdf5Value(const std::int64_t& value);               // NOLINT: one integer
  Hdf5Value(const std::string& value);                // NOLINT: one text, UTF-8 without zero bytes
  Hdf5Value(const Points& value);                     // NOLINT: [rows, columns]
  Hdf5Value(const Vector& value);                     // NOLINT: [size]
  Hdf5Value(const Array& value);                      // NOLINT: numbers of any shape
  Hdf5Value(const std::vector<double>& value);        // NOLINT: [size]
  Hdf5Value(const std::vector<std::int64_t>& value);  // NOLINT: integers [size]
  Hdf5Value(const std::vector<std::string>& value);   // NOLINT: texts [size]
  Hdf5Value(const std::vector<std::uint8_t>& value);  // NOLINT: bytes [size]

 private:
  friend class Hdf5Writer;  // its Stored
  enum class Kind { numbers, integers, texts, bytes };
  Hdf5Value(Kind kind, std::vector<Eigen::Index> shape, const void* values, std::size_t count);

  Kind kind_;
  std::vector<unsigned long long> shape_;  // empty: a single value
  const void* values_;
  std::size_t count_;  // of values that are there
};

// Writes an HDF5 file whole or not at all. The file is built in memory; commit() writes it as
// write_atomic_file does, with its digest (file_digest.h). The same calls give the same bytes. Items are named by slash paths ("/data/train");
// groups on the way are made. Every failure throws Error naming the file and the item.
class Hdf5Writer {
 public:
  explicit Hdf5Writer(const std::string& path);  // touches no file before commit()
  ~Hdf5Writer();                                 // without commit(), leaves nothing behind
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  // Makes a group and those on the way to it; nothing happens if it is there.
  void make_group(const std::string& group);
  // Writes one dataset; throws Error if the item exists.
  void write(const std::string& item, const Hdf5Value& value);
  // Writes one attribute of a group (made if it is missing) or of a dataset.
  void write_attribute(const std::string& item, const std::string& name, const Hdf5Value& value);

  // Replaces the file at `path`. Nothing can be written afterwards.
  void commit();

 private:
  struct Stored;
  void check_open(const std::string& item) const;

  std::string path_;
  std::int64_t file_ = -1;  // HDF5 identifier
};

// Reads an HDF5 file that the writer above or another program wrote. Every failure, a missing item or one of
// another type or shape included, throws Error naming the file and the item. The file may be replaced while
// it is being read.
class Hdf5Reader {
 public:
  // Throws Error when the file is missing, not HDF5, truncated, or not the bytes that Hdf5Writer wrote (files of
  // others carry no digest, so that damage to them shows less surely).
  explicit Hdf5Reader(const std::string& path);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;

  const std::string& path() const { return path_; }  // as given
  bool exists(const std::string& item) const;        // a group or a dataset of this name
  // Whether `item` exists and has an attribute of this name.
  bool has_attribute(const std::string& item, const std::string& name) const;
  // The names in a group, in the order in which they were written (of files that do not keep it, in the order
  // of the names).
  std::vector<std::string> children(const std::string& group) const;
  // The names of a group's or a dataset's attributes, in the same order.
  std::vector<std::string> attributes(const std::string& item) const;

  // The value of a dataset. T is a type that Hdf5Value takes. Only an Array may come from integers as well as
  // from numbers.
  template <typename T>
  T read(const std::string& item) const;
  // The value of an attribute. T: as for read(), without Points, Vector and Array.
  template <typename T>
  T attribute(const std::string& item, const std::string& name) const;

  Points read_points(const std::string& item) const { return read<Points>(item); }  // [N, n]
  Vector read_vector(const std::string& item) const { return read<Vector>(item); }  // [N]
  Array read_array(const std::string& item) const { return read<Array>(item); }     // any shape
  // A dataset of integers [N].
  std::vector<std::int64_t> read_integers(const std::string& item) const {
    return read<std::vector<std::int64_t>>(item);
  }
  // A dataset of one text of variable length.
  std::string read_text(const std::string& item) const { return read<std::string>(item); }
  // A dataset of texts [N].
  std::vector<std::string> read_texts(const std::string& item) const {
    return read<std::vector<std::string>>(item);
  }
  // A dataset of bytes [N].
  std::vector<std::uint8_t> read_bytes(const std::string& item) const {
    return read<std::vector<std::uint8_t>>(item);
  }
  // A dataset of one number.
  double read_number(const std::string& item) const { return read<double>(item); }
  // A dataset of one integer.
  std::int64_t read_integer(const std::string& item) const { return read<std::int64_t>(item); }
  // An attribute of one text.
  std::string text_attribute(const std::string& item, const std::string& name) const {
    return attribute<std::string>(item, name);
  }
  // An attribute of one number.
  double number_attribute(const std::string& item, const std::string& name) const {
    return attribute<double>(item, name);
  }
  // An attribute of one integer.
  std::int64_t integer_attribute(const std::string& item, const std::string& name) const {
    return attribute<std::int64_t>(item, name);
  }

 private:
  class Source;

  std::string path_;
  std::int64_t file_ = -1;       // HDF5 identifier
  std::uint64_t file_size_ = 0;  // bytes
};

}  // namespace s2nnds
