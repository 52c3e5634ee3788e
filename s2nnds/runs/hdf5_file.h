#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/core/points.h"

namespace s2nnds {

std::string hdf5_version();  // "1.10.8"

// Numbers of any shape, the last index running fastest.
struct Array {
  std::vector<Eigen::Index> shape;
  std::vector<double> values;
};

// Writes an HDF5 file whole or not at all. The file is built in memory; commit() writes it beside `path`,
// flushes it to the disk and renames it, so that a crash or a full disk leaves the old file or the new one,
// never half of one. The same calls give the same bytes. Items are named by slash paths ("/data/train");
// groups on the way are made. Every failure throws Error naming the file and the item.
class Hdf5Writer {
 public:
  // Throws Error unless a file can be made in the directory of `path`.
  explicit Hdf5Writer(const std::string& path);
  ~Hdf5Writer();  // without commit(), leaves nothing behind
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  void make_group(const std::string& group);

  // One dataset. Of matrices numpy sees [rows, cols].
  void write(const std::string& item, const Points& value);
  void write(const std::string& item, const Vector& value);
  void write(const std::string& item, const Array& value);
  void write(const std::string& item, const std::vector<std::int64_t>& value);
  void write(const std::string& item, const std::string& value);  // UTF-8
  void write(const std::string& item, const std::vector<std::string>& value);
  void write(const std::string& item, double value);
  void write(const std::string& item, std::int64_t value);

  // One attribute of a group (made if it is missing) or of a dataset.
  void write_attribute(const std::string& item, const std::string& name, const std::string& value);
  void write_attribute(const std::string& item, const std::string& name, double value);
  void write_attribute(const std::string& item, const std::string& name, std::int64_t value);
  void write_attribute(const std::string& item, const std::string& name, const std::vector<double>& value);
  void write_attribute(const std::string& item, const std::string& name,
                       const std::vector<std::int64_t>& value);
  void write_attribute(const std::string& item, const std::string& name,
                       const std::vector<std::string>& value);

  // Replaces the file at `path`. Nothing can be written afterwards.
  void commit();

 private:
  struct Contents;
  void write_contents(const std::string& item, const Contents& contents);
  void write_attribute_contents(const std::string& item, const std::string& name, const Contents& contents);
  void check_open(const std::string& item) const;
  std::string image() const;

  std::string path_;
  std::string partial_path_;
  int partial_ = -1;        // file descriptor
  std::int64_t file_ = -1;  // HDF5 identifier
};

// Reads a file that Hdf5Writer wrote. Every failure, a missing item or one of another type or shape included,
// throws Error naming the file and the item. The file may be replaced while it is being read.
class Hdf5Reader {
 public:
  // Throws Error when the file is missing, not HDF5 or truncated.
  explicit Hdf5Reader(const std::string& path);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;

  const std::string& path() const { return path_; }
  bool exists(const std::string& item) const;
  // The names in a group, in the order in which they were written.
  std::vector<std::string> children(const std::string& group) const;

  Points read_points(const std::string& item) const;
  Vector read_vector(const std::string& item) const;
  Array read_array(const std::string& item) const;
  std::vector<std::int64_t> read_integers(const std::string& item) const;
  std::string read_text(const std::string& item) const;
  std::vector<std::string> read_texts(const std::string& item) const;
  double read_number(const std::string& item) const;
  std::int64_t read_integer(const std::string& item) const;

  bool has_attribute(const std::string& item, const std::string& name) const;
  // The names of a group's or a dataset's attributes, in the order in which they were written.
  std::vector<std::string> attributes(const std::string& item) const;
  std::string text_attribute(const std::string& item, const std::string& name) const;
  double number_attribute(const std::string& item, const std::string& name) const;
  std::int64_t integer_attribute(const std::string& item, const std::string& name) const;
  std::vector<double> numbers_attribute(const std::string& item, const std::string& name) const;
  std::vector<std::int64_t> integers_attribute(const std::string& item, const std::string& name) const;
  std::vector<std::string> texts_attribute(const std::string& item, const std::string& name) const;

 private:
  class Source;
  Source dataset(const std::string& item) const;
  Source attribute(const std::string& item, const std::string& name) const;

  std::string path_;
  std::int64_t file_ = -1;       // HDF5 identifier
  std::uint64_t file_size_ = 0;  // bytes
};

}  // namespace s2nnds
