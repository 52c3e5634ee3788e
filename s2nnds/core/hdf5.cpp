// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/hdf5.h"

#include <fmt/ranges.h>
#include <hdf5.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numeric>
#include <sstream>
#include <utility>

#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/file_digest.h"
#include "s2nnds/core/printable.h"

namespace s2nnds {
namespace {

static_assert(sizeof(hid_t) == sizeof(std::int64_t));

// When a process ends that could not close a damaged file, HDF5 would complain of it on the standard error.
// Nothing is lost without that clean-up: files are written by commit(). It has to be called off before anything
// else of HDF5 is called, so at the start of the program.
[[maybe_unused]] const herr_t without_clean_up = H5dont_atexit();

// Keeps HDF5 from printing its error stack in the current scope: the errors become exceptions.
class Quiet {
 public:
  Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

// Closes an HDF5 identifier.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle& operator=(Handle&&) = delete;

  operator hid_t() const { return id_; }
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// What HDF5 itself says of its last failure: the innermost message.
std::string reason() {
  std::string text;
  const auto take = [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
    auto& first = *static_cast<std::string*>(out);
    if (first.empty() && error->desc != nullptr) first = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &text);
  return text.empty() ? "HDF5 gave no reason" : printable(text);
}

// Files in memory are told apart by their names, also from those of other threads.
std::string unique_name() {
  static std::atomic<std::uint64_t> count{0};
  return fmt::format("s2nnds-in-memory-{}", count++);
}

Handle in_memory() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  constexpr std::size_t increment = 1 << 16;
  H5Pset_fapl_core(access, increment, false);
  return access;
}

// Properties for something to be made. No time stamps, so that equal contents are equal bytes; children and
// attributes keep their order.
Handle ordered(hid_t kind) {
  Handle properties(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  H5Pset_link_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  H5Pset_attr_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  return properties;
}

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

std::string absolute(const std::string& item) { return item.starts_with("/") ? item : "/" + item; }

// "/a", "/a/b" for "/a/b". A link's name may hold any character but the slash.
std::vector<std::string> path_to(const std::string& item) {
  std::vector<std::string> paths;
  std::istringstream in(item);
  for (std::string name; std::getline(in, name, '/');) {
    if (!name.empty()) paths.push_back((paths.empty() ? "" : paths.back()) + "/" + name);
  }
  return paths;
}

// H5Lexists wants every group on the way to exist.
bool link_exists(hid_t file, const std::string& item) {
  const std::vector<std::string> paths = path_to(item);
  return std::all_of(paths.begin(), paths.end(), [file](const std::string& path) {
    return H5Lexists(file, path.c_str(), H5P_DEFAULT) > 0;
  });
}

// `list(index, take, &names)` calls `take` for every name. Other programs may have written the file
// without keeping the order.
template <typename Info, typename List>
std::vector<std::string> names_of(const std::string& where, const List& list) {
  std::vector<std::string> names;
  const auto take = [](hid_t, const char* name, const Info*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  for (const H5_index_t index : {H5_INDEX_CRT_ORDER, H5_INDEX_NAME}) {
    names.clear();
    if (list(index, take, &names) >= 0) return names;
  }
  fail("{}: cannot list it: {}", where, reason());
}

std::string shape_text(const std::vector<hsize_t>& shape) {
  return shape.empty() ? "one value" : fmt::format("shape [{}]", fmt::join(shape, ", "));
}

}  // namespace

std::string hdf5_version() {
  unsigned major = 0;
  unsigned minor = 0;
  unsigned release = 0;
  H5get_libversion(&major, &minor, &release);
  return fmt::format("{}.{}.{}", major, minor, release);
}

// ---- Writing

Hdf5Value::Hdf5Value(Kind kind, std::vector<Eigen::Index> shape, const void* values, std::size_t count)
    : kind_(kind), shape_(shape.begin(), shape.end()), values_(values), count_(count) {}
Hdf5Value::Hdf5Value(const double& value) : Hdf5Value(Kind::numbers, {}, &value, 1) {}
Hdf5Value::Hdf5Value(const std::int64_t& value) : Hdf5Value(Kind::integers, {}, &value, 1) {}
Hdf5Value::Hdf5Value(const std::string& value) : Hdf5Value(Kind::texts, {}, &value, 1) {}
Hdf5Value::Hdf5Value(const Points& value)
    : Hdf5Value(Kind::numbers, {value.rows(), value.cols()}, value.data(),
                static_cast<std::size_t>(value.size())) {}
Hdf5Value::Hdf5Value(const Vector& value)
    : Hdf5Value(Kind::numbers, {value.size()}, value.data(), static_cast<std::size_t>(value.size())) {}
Hdf5Value::Hdf5Value(const Array& value)
    : Hdf5Value(Kind::numbers, value.shape, value.values.data(), value.values.size()) {}
Hdf5Value::Hdf5Value(const std::vector<double>& value)
    : Hdf5Value(Kind::numbers, {static_cast<Eigen::Index>(value.size())}, value.data(), value.size()) {}
Hdf5Value::Hdf5Value(const std::vector<std::int64_t>& value)
    : Hdf5Value(Kind::integers, {static_cast<Eigen::Index>(value.size())}, value.data(), value.size()) {}
Hdf5Value::Hdf5Value(const std::vector<std::string>& value)
    : Hdf5Value(Kind::texts, {static_cast<Eigen::Index>(value.size())}, value.data(), value.size()) {}
Hdf5Value::Hdf5Value(const std::vector<std::uint8_t>& value)
    : Hdf5Value(Kind::bytes, {static_cast<Eigen::Index>(value.size())}, value.data(), value.size()) {}

// A value as HDF5 takes it; `where` names what it is written to.
struct Hdf5Writer::Stored {
  Stored(const Hdf5Value& value, std::string name)
      : where(std::move(name)),
        text(text_type()),
        shape(value.shape_.begin(), value.shape_.end()),
        space(shape.empty() ? H5Screate(H5S_SCALAR)
                            : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
              H5Sclose),
        values(value.values_) {
    const hsize_t count = std::accumulate(shape.begin(), shape.end(), hsize_t{1}, std::multiplies<>());
    check(count == value.count_, "{}: cannot write it: found {} values, expected {} of its shape [{}]", where,
          value.count_, count, fmt::join(shape, ", "));
    if (value.kind_ == Hdf5Value::Kind::numbers) {
      file_type = H5T_IEEE_F64LE;
      memory_type = H5T_NATIVE_DOUBLE;
    } else if (value.kind_ == Hdf5Value::Kind::integers) {
      file_type = H5T_STD_I64LE;
      memory_type = H5T_NATIVE_INT64;
    } else if (value.kind_ == Hdf5Value::Kind::bytes) {
      file_type = H5T_STD_U8LE;
      memory_type = H5T_NATIVE_UINT8;
    } else {
      file_type = memory_type = text;
      const auto* first = static_cast<const std::string*>(value.values_);
      for (const std::string* one = first; one != first + count; ++one) {
        // HDF5 ends a text at its first zero byte, so one inside would be lost in silence.
        check(one->find('\0') == std::string::npos, "{}: cannot write a text that holds a zero byte", where);
        texts.push_back(one->c_str());
      }
      values = texts.data();
    }
    if (values == nullptr) values = this;  // HDF5 wants an address even where there is nothing to write
  }

  void check_done(bool done) const {
    if (!done) fail("{}: cannot write it: {}", where, reason());
  }

  std::string where;
  Handle text;
  std::vector<hsize_t> shape;  // another type of integer from HDF5 1.14 on
  Handle space;
  hid_t file_type = -1;
  hid_t memory_type = -1;
  const void* values;
  std::vector<const char*> texts;
};

Hdf5Writer::Hdf5Writer(const std::string& path) : path_(path) {
  const Quiet quiet;
  file_ = H5Fcreate(unique_name().c_str(), H5F_ACC_TRUNC, ordered(H5P_FILE_CREATE), in_memory());
  if (file_ < 0) fail("{}: cannot make an HDF5 file: {}", path, reason());
}

Hdf5Writer::~Hdf5Writer() {
  const Quiet quiet;
  if (file_ >= 0) H5Fclose(file_);
}

void Hdf5Writer::check_open(const std::string& item) const {
  check(file_ >= 0, "{}: {}: cannot write it: the file has been committed", path_, absolute(item));
}

void Hdf5Writer::make_group(const std::string& group) {
  const Quiet quiet;
  check_open(group);
  const Handle creation = ordered(H5P_GROUP_CREATE);
  for (const std::string& path : path_to(group)) {
    if (H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0) continue;
    const Handle made(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
    if (!made.valid()) fail("{}: {}: cannot write it: {}", path_, path, reason());
  }
}

void Hdf5Writer::write(const std::string& item, const Hdf5Value& value) {
  const Quiet quiet;
  check_open(item);
  const std::string name = absolute(item);
  make_group(name.substr(0, name.rfind('/')));
  const Stored stored(value, fmt::format("{}: {}", path_, name));
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  const Handle made(
      H5Dcreate2(file_, name.c_str(), stored.file_type, stored.space, H5P_DEFAULT, creation, H5P_DEFAULT),
      H5Dclose);
  stored.check_done(made.valid() &&
                    H5Dwrite(made, stored.memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, stored.values) >= 0);
}

void Hdf5Writer::write_attribute(const std::string& item, const std::string& name, const Hdf5Value& value) {
  const Quiet quiet;
  check_open(item);
  if (!link_exists(file_, item)) make_group(item);
  const Stored stored(value, fmt::format("{}: attribute {} of {}", path_, name, absolute(item)));
  const Handle owner(H5Oopen(file_, absolute(item).c_str(), H5P_DEFAULT), H5Oclose);
  const Handle made(H5Acreate2(owner, name.c_str(), stored.file_type, stored.space, H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
  stored.check_done(made.valid() && H5Awrite(made, stored.memory_type, stored.values) >= 0);
}

void Hdf5Writer::commit() {
  const Quiet quiet;
  check(file_ >= 0, "{}: cannot write: the file has been committed", path_);
  H5Fflush(file_, H5F_SCOPE_GLOBAL);
  const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
  std::string bytes(size > 0 ? static_cast<std::size_t>(size) : 0, '\0');
  if (size <= 0 || H5Fget_file_image(file_, bytes.data(), bytes.size()) != size) {
    fail("{}: cannot write it: {}", path_, reason());
  }
  H5Fclose(std::exchange(file_, -1));
  const std::string whole = with_digest(std::move(bytes));
  write_atomic_file(path_, whole, fmt::format("{} bytes", whole.size()));
}

// ---- Reading

// A dataset or an attribute to read from.
class Hdf5Reader::Source {
 public:
  Source(std::string name, Handle id, bool is_attribute, std::uint64_t file_size)
      : name_(std::move(name)),
        id_(std::move(id)),
        is_attribute_(is_attribute),
        type_(is_attribute ? H5Aget_type(id_) : H5Dget_type(id_), H5Tclose),
        space_(is_attribute ? H5Aget_space(id_) : H5Dget_space(id_), H5Sclose) {
    const int rank = H5Sget_simple_extent_ndims(space_);
    shape_.resize(rank > 0 ? static_cast<std::size_t>(rank) : 0);
    if (!type_.valid() || rank < 0 || H5Sget_simple_extent_dims(space_, shape_.data(), nullptr) < 0)
      fail_to_read();
    // A damaged shape shows by its size, before memory is taken for it. Deflate shrinks 1,032 bytes to one at
    // best.
    double bytes = static_cast<double>(H5Tget_size(type_)) / (may_be_compressed() ? 1032.0 : 1.0);
    for (const hsize_t side : shape_) bytes *= static_cast<double>(side);
    check(bytes <= static_cast<double>(file_size), "{}: found {}, more than the file of {} bytes holds",
          name_, shape_text(shape_), file_size);
  }

  void get(Points& value) const {
    const std::vector<double> all = numbers(2);
    value = Eigen::Map<const Points>(all.data(), static_cast<Eigen::Index>(shape_[0]),
                                     static_cast<Eigen::Index>(shape_[1]));
  }
  void get(Vector& value) const {
    const std::vector<double> all = numbers(1);
    value = Eigen::Map<const Vector>(all.data(), static_cast<Eigen::Index>(all.size()));
  }
  void get(Array& value) const {
    value.shape.assign(shape_.begin(), shape_.end());
    value.values = H5Tget_class(type_) == H5T_INTEGER ? read<double>(H5T_NATIVE_DOUBLE) : numbers(kAnyRank);
  }
  void get(double& value) const { value = numbers(0).front(); }
  void get(std::int64_t& value) const { value = integers(0).front(); }
  void get(std::string& value) const { value = texts(0).front(); }
  void get(std::vector<double>& value) const { value = numbers(1); }
  void get(std::vector<std::int64_t>& value) const { value = integers(1); }
  void get(std::vector<std::string>& value) const { value = texts(1); }
  void get(std::vector<std::uint8_t>& value) const {
    expect(H5T_INTEGER, 1, "bytes");
    value = read<std::uint8_t>(H5T_NATIVE_UINT8);
  }

 private:
  static constexpr int kAnyRank = -1;

  [[noreturn]] void fail_to_read() const { fail("{}: cannot read it: {}", name_, reason()); }

  bool may_be_compressed() const {
    if (is_attribute_) return false;
    const Handle creation(H5Dget_create_plist(id_), H5Pclose);
    return H5Pget_layout(creation) == H5D_CHUNKED;
  }

  std::vector<double> numbers(int rank) const {
    expect(H5T_FLOAT, rank, "numbers");
    return read<double>(H5T_NATIVE_DOUBLE);
  }
  std::vector<std::int64_t> integers(int rank) const {
    expect(H5T_INTEGER, rank, "integers");
    return read<std::int64_t>(H5T_NATIVE_INT64);
  }
  std::vector<std::string> texts(int rank) const {
    expect(H5T_STRING, rank, "text");
    check(H5Tis_variable_str(type_) > 0, "{}: expected text of variable length, found text of fixed length",
          name_);
    const Handle type = text_type();
    const std::vector<char*> stored = read<char*>(type);
    std::vector<std::string> all;
    for (const char* text : stored) all.emplace_back(text != nullptr ? text : "");
    H5Dvlen_reclaim(type, space_, H5P_DEFAULT, const_cast<char**>(stored.data()));
    return all;
  }

  void expect(H5T_class_t wanted, int rank, std::string_view what) const {
    const H5T_class_t type = H5Tget_class(type_);
    const std::string_view found = type == H5T_FLOAT     ? "numbers"
                                   : type == H5T_INTEGER ? "integers"
                                   : type == H5T_STRING  ? "text"
                                                         : "another type";
    check(type == wanted && (rank == kAnyRank || rank == static_cast<int>(shape_.size())),
          "{}: expected {} of {}, found {} of {}", name_, what,
          rank == kAnyRank ? "any shape"
          : rank == 0      ? "one value"
                           : fmt::format("{} dimension{}", rank, rank > 1 ? "s" : ""),
          found, shape_text(shape_));
  }

  template <typename T>
  std::vector<T> read(hid_t memory_type) const {
    std::size_t count = 1;
    for (const hsize_t side : shape_) count *= side;
    std::vector<T> values(count);
    if (count == 0) return values;
    const herr_t result = is_attribute_
                              ? H5Aread(id_, memory_type, values.data())
                              : H5Dread(id_, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    if (result < 0) fail_to_read();
    return values;
  }

  std::string name_;
  Handle id_;
  bool is_attribute_;
  Handle type_;
  Handle space_;
  std::vector<hsize_t> shape_;  // empty: a single value
};

Hdf5Reader::Hdf5Reader(const std::string& path) : path_(path) {
  const Quiet quiet;
  check(!std::filesystem::is_directory(path), "{}: expected an HDF5 file, found a directory", path);
  std::ifstream in(path, std::ios::binary);
  check(in.is_open(), "{}: cannot read it: {}", path, std::strerror(errno));
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  bytes = without_digest(std::move(bytes), path);
  file_size_ = bytes.size();
  check(file_size_ > 0, "{}: expected an HDF5 file, found an empty file", path);
  const Handle access = in_memory();
  H5Pset_file_image(access, bytes.data(), bytes.size());
  file_ = H5Fopen(unique_name().c_str(), H5F_ACC_RDONLY, access);
  if (file_ < 0) fail("{}: expected a whole HDF5 file, found {} bytes: {}", path, file_size_, reason());
}

Hdf5Reader::~Hdf5Reader() {
  const Quiet quiet;
  H5Fclose(file_);
}

bool Hdf5Reader::exists(const std::string& item) const {
  const Quiet quiet;
  return link_exists(file_, item);
}

bool Hdf5Reader::has_attribute(const std::string& item, const std::string& name) const {
  const Quiet quiet;
  return link_exists(file_, item) &&
         H5Aexists_by_name(file_, absolute(item).c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5Reader::children(const std::string& group) const {
  const Quiet quiet;
  const Handle opened(H5Gopen2(file_, absolute(group).c_str(), H5P_DEFAULT), H5Gclose);
  check(opened.valid(), "{}: expected a group {}, found none", path_, absolute(group));
  return names_of<H5L_info_t>(fmt::format("{}: {}", path_, absolute(group)),
                              [&](H5_index_t index, H5L_iterate_t take, void* names) {
                                return H5Literate(opened, index, H5_ITER_INC, nullptr, take, names);
                              });
}

std::vector<std::string> Hdf5Reader::attributes(const std::string& item) const {
  const Quiet quiet;
  const Handle owner(H5Oopen(file_, absolute(item).c_str(), H5P_DEFAULT), H5Oclose);
  check(owner.valid(), "{}: expected an item {}, found none", path_, absolute(item));
  return names_of<H5A_info_t>(fmt::format("{}: attributes of {}", path_, absolute(item)),
                              [&](H5_index_t index, H5A_operator2_t take, void* names) {
                                return H5Aiterate2(owner, index, H5_ITER_INC, nullptr, take, names);
                              });
}

template <typename T>
T Hdf5Reader::read(const std::string& item) const {
  const Quiet quiet;
  const std::string name = absolute(item);
  Handle opened(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  check(opened.valid(), "{}: expected a dataset {}, found none", path_, name);
  T value;
  Source(fmt::format("{}: {}", path_, name), std::move(opened), false, file_size_).get(value);
  return value;
}

template <typename T>
T Hdf5Reader::attribute(const std::string& item, const std::string& name) const {
  const Quiet quiet;
  const std::string owner = absolute(item);
  Handle opened(H5Aopen_by_name(file_, owner.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(opened.valid(), "{}: expected an attribute {} of {}, found none", path_, name, owner);
  T value;
  Source(fmt::format("{}: attribute {} of {}", path_, name, owner), std::move(opened), true, file_size_)
      .get(value);
  return value;
}

template Points Hdf5Reader::read(const std::string&) const;
template Vector Hdf5Reader::read(const std::string&) const;
template Array Hdf5Reader::read(const std::string&) const;
template double Hdf5Reader::read(const std::string&) const;
template std::int64_t Hdf5Reader::read(const std::string&) const;
template std::string Hdf5Reader::read(const std::string&) const;
template std::vector<double> Hdf5Reader::read(const std::string&) const;
template std::vector<std::int64_t> Hdf5Reader::read(const std::string&) const;
template std::vector<std::string> Hdf5Reader::read(const std::string&) const;
template std::vector<std::uint8_t> Hdf5Reader::read(const std::string&) const;
template double Hdf5Reader::attribute(const std::string&, const std::string&) const;
template std::int64_t Hdf5Reader::attribute(const std::string&, const std::string&) const;
template std::string Hdf5Reader::attribute(const std::string&, const std::string&) const;
template std::vector<double> Hdf5Reader::attribute(const std::string&, const std::string&) const;
template std::vector<std::int64_t> Hdf5Reader::attribute(const std::string&, const std::string&) const;
template std::vector<std::string> Hdf5Reader::attribute(const std::string&, const std::string&) const;

}  // namespace s2nnds
