#include "s2nnds/runs/hdf5_file.h"

#include <fcntl.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

static_assert(sizeof(hid_t) == sizeof(std::int64_t));

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
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "HDF5 gave no reason" : text;
}

[[noreturn]] void fail_to_write(const std::string& path, const std::string& item) {
  fail("{}: {}: cannot write it: {}", path, item, reason());
}

std::string system_reason() { return std::strerror(errno); }

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

// No time stamps, so that equal contents are equal bytes; children and attributes keep their order.
void set_order(hid_t properties) {
  H5Pset_obj_track_times(properties, false);
  H5Pset_link_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  H5Pset_attr_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
}

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

// HDF5 ends a text at its first zero byte, so one inside would be lost in silence.
const char* c_text(const std::string& path, const std::string& item, const std::string& text) {
  check(text.find('\0') == std::string::npos, "{}: {}: cannot write a text that holds a zero byte", path,
        item);
  return text.c_str();
}

std::string absolute(const std::string& item) { return item.starts_with("/") ? item : "/" + item; }

// A link's name may hold any character but the slash, which parts names.
std::vector<std::string> parts(const std::string& item) {
  std::vector<std::string> names;
  std::istringstream in(item);
  for (std::string name; std::getline(in, name, '/');) {
    if (!name.empty()) names.push_back(name);
  }
  return names;
}

// H5Lexists wants every group on the way to exist.
bool link_exists(hid_t file, const std::string& item) {
  std::string here;
  for (const std::string& name : parts(item)) {
    here += "/" + name;
    if (H5Lexists(file, here.c_str(), H5P_DEFAULT) <= 0) return false;
  }
  return true;
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

// Values in memory, with their types here and in the file.
struct Hdf5Writer::Contents {
  hid_t file_type;
  hid_t memory_type;
  std::vector<hsize_t> shape;  // empty: a single value
  const void* values;

  Handle space() const {
    if (shape.empty()) return {H5Screate(H5S_SCALAR), H5Sclose};
    return {H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose};
  }
  // HDF5 wants an address even where there is nothing to write.
  const void* memory() const { return values != nullptr ? values : this; }
  static Contents numbers(std::vector<hsize_t> shape, const double* values) {
    return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, std::move(shape), values};
  }
  static Contents integers(std::vector<hsize_t> shape, const std::int64_t* values) {
    return {H5T_STD_I64LE, H5T_NATIVE_INT64, std::move(shape), values};
  }
};

Hdf5Writer::Hdf5Writer(const std::string& path) : path_(path) {
  const Quiet quiet;
  int attempt = 0;
  do {  // several processes may write the same run on a shared disk
    partial_path_ = fmt::format("{}.{}-{}.partial", path, getpid(), attempt++);
    partial_ = open(partial_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (partial_ < 0 && errno == EEXIST);
  check(partial_ >= 0, "{}: cannot make the file: {}", path, system_reason());

  const Handle access = in_memory();
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  set_order(creation);
  file_ = H5Fcreate(unique_name().c_str(), H5F_ACC_TRUNC, creation, access);
  if (file_ < 0) {
    close(partial_);
    unlink(partial_path_.c_str());
    fail("{}: cannot make an HDF5 file: {}", path, reason());
  }
}

Hdf5Writer::~Hdf5Writer() {
  const Quiet quiet;
  if (file_ >= 0) H5Fclose(file_);
  if (partial_ >= 0) {
    close(partial_);
    unlink(partial_path_.c_str());
  }
}

void Hdf5Writer::check_open(const std::string& item) const {
  check(file_ >= 0, "{}: {}: cannot write it: the file has been committed", path_, item);
}

void Hdf5Writer::make_group(const std::string& group) {
  const Quiet quiet;
  check_open(group);
  const Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  set_order(creation);
  std::string here;
  for (const std::string& name : parts(group)) {
    here += "/" + name;
    if (H5Lexists(file_, here.c_str(), H5P_DEFAULT) > 0) continue;
    const Handle made(H5Gcreate2(file_, here.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
    if (!made.valid()) fail_to_write(path_, here);
  }
}

void Hdf5Writer::write_contents(const std::string& item, const Contents& contents) {
  const Quiet quiet;
  const std::string name = absolute(item);
  check_open(name);
  make_group(name.substr(0, name.rfind('/')));
  const Handle space = contents.space();
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  const Handle dataset(
      H5Dcreate2(file_, name.c_str(), contents.file_type, space, H5P_DEFAULT, creation, H5P_DEFAULT),
      H5Dclose);
  if (!dataset.valid() ||
      H5Dwrite(dataset, contents.memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, contents.memory()) < 0) {
    fail_to_write(path_, name);
  }
}

void Hdf5Writer::write_attribute_contents(const std::string& item, const std::string& name,
                                          const Contents& contents) {
  const Quiet quiet;
  if (!link_exists(file_, item)) make_group(item);
  const Handle owner(H5Oopen(file_, absolute(item).c_str(), H5P_DEFAULT), H5Oclose);
  const Handle space = contents.space();
  const Handle attribute(H5Acreate2(owner, name.c_str(), contents.file_type, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  if (!attribute.valid() || H5Awrite(attribute, contents.memory_type, contents.memory()) < 0) {
    fail_to_write(path_, fmt::format("attribute {} of {}", name, absolute(item)));
  }
}

void Hdf5Writer::write(const std::string& item, const Points& value) {
  write_contents(item,
                 Contents::numbers({static_cast<hsize_t>(value.rows()), static_cast<hsize_t>(value.cols())},
                                   value.data()));
}
void Hdf5Writer::write(const std::string& item, const Vector& value) {
  write_contents(item, Contents::numbers({static_cast<hsize_t>(value.size())}, value.data()));
}
void Hdf5Writer::write(const std::string& item, const Array& value) {
  Eigen::Index count = 1;
  for (const Eigen::Index side : value.shape) count *= side;
  check(count == static_cast<Eigen::Index>(value.values.size()),
        "{}: {}: cannot write it: found {} values, expected {} of its shape [{}]", path_, item,
        value.values.size(), count, fmt::join(value.shape, ", "));
  write_contents(item, Contents::numbers({value.shape.begin(), value.shape.end()}, value.values.data()));
}
void Hdf5Writer::write(const std::string& item, const std::vector<std::int64_t>& value) {
  write_contents(item, Contents::integers({value.size()}, value.data()));
}
void Hdf5Writer::write(const std::string& item, const std::string& value) {
  const Handle type = text_type();
  const char* text = c_text(path_, item, value);
  write_contents(item, {type, type, {}, &text});
}
void Hdf5Writer::write(const std::string& item, const std::vector<std::string>& value) {
  const Handle type = text_type();
  std::vector<const char*> texts;
  for (const std::string& text : value) texts.push_back(c_text(path_, item, text));
  write_contents(item, {type, type, {value.size()}, texts.data()});
}
void Hdf5Writer::write(const std::string& item, double value) {
  write_contents(item, Contents::numbers({}, &value));
}
void Hdf5Writer::write(const std::string& item, std::int64_t value) {
  write_contents(item, Contents::integers({}, &value));
}

void Hdf5Writer::write_attribute(const std::string& item, const std::string& name, const std::string& value) {
  const Handle type = text_type();
  const char* text = c_text(path_, name, value);
  write_attribute_contents(item, name, {type, type, {}, &text});
}
void Hdf5Writer::write_attribute(const std::string& item, const std::string& name, double value) {
  write_attribute_contents(item, name, Contents::numbers({}, &value));
}
void Hdf5Writer::write_attribute(const std::string& item, const std::string& name, std::int64_t value) {
  write_attribute_contents(item, name, Contents::integers({}, &value));
}
void Hdf5Writer::write_attribute(const std::string& item, const std::string& name,
                                 const std::vector<double>& value) {
  write_attribute_contents(item, name, Contents::numbers({value.size()}, value.data()));
}
void Hdf5Writer::write_attribute(const std::string& item, const std::string& name,
                                 const std::vector<std::int64_t>& value) {
  write_attribute_contents(item, name, Contents::integers({value.size()}, value.data()));
}
void Hdf5Writer::write_attribute(const std::string& item, const std::string& name,
                                 const std::vector<std::string>& value) {
  const Handle type = text_type();
  std::vector<const char*> texts;
  for (const std::string& text : value) texts.push_back(c_text(path_, name, text));
  write_attribute_contents(item, name, {type, type, {value.size()}, texts.data()});
}

std::string Hdf5Writer::image() const {
  const Quiet quiet;
  H5Fflush(file_, H5F_SCOPE_GLOBAL);
  const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
  std::string bytes(size > 0 ? static_cast<std::size_t>(size) : 0, '\0');
  if (size <= 0 || H5Fget_file_image(file_, bytes.data(), bytes.size()) != size)
    fail_to_write(path_, "the file");
  return bytes;
}

void Hdf5Writer::commit() {
  const Quiet quiet;
  check(file_ >= 0, "{}: cannot write: the file has been committed", path_);
  const std::string bytes = image();
  H5Fclose(std::exchange(file_, -1));
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = ::write(partial_, bytes.data() + done, bytes.size() - done);
    check(count > 0 || (count < 0 && errno == EINTR), "{}: cannot write {} bytes: {}", path_, bytes.size(),
          system_reason());
    done += count > 0 ? static_cast<std::size_t>(count) : 0;
  }
  if (fsync(partial_) != 0) fail("{}: cannot write {} bytes: {}", path_, bytes.size(), system_reason());
  if (rename(partial_path_.c_str(), path_.c_str()) != 0)
    fail("{}: cannot replace it: {}", path_, system_reason());
  close(std::exchange(partial_, -1));

  // The new name lasts only once the directory is on the disk as well. The file is whole either way.
  const std::string directory = std::filesystem::path(path_).parent_path().string();
  const int folder = open(directory.empty() ? "." : directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    fsync(folder);
    close(folder);
  }
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
    if (!type_.valid() || rank < 0 || H5Sget_simple_extent_dims(space_, shape_.data(), nullptr) < 0) {
      fail("{}: cannot read it: {}", name_, reason());
    }
    // Nothing is stored compressed, so a damaged shape shows by its size, before memory is taken for it.
    double bytes = static_cast<double>(H5Tget_size(type_));
    for (const hsize_t side : shape_) bytes *= static_cast<double>(side);
    check(bytes <= static_cast<double>(file_size), "{}: found {}, more than the file of {} bytes holds",
          name_, shape_text(shape_), file_size);
  }

  const std::vector<hsize_t>& shape() const { return shape_; }

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

 private:
  // any_rank: every rank will do.
  void expect(H5T_class_t wanted, int rank, std::string_view what) const {
    const H5T_class_t type = H5Tget_class(type_);
    const std::string_view found = type == H5T_FLOAT     ? "numbers"
                                   : type == H5T_INTEGER ? "integers"
                                   : type == H5T_STRING  ? "text"
                                                         : "another type";
    check(type == wanted && (rank == any_rank || rank == static_cast<int>(shape_.size())),
          "{}: expected {} of {}, found {} of {}", name_, what,
          rank == any_rank ? "any shape"
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
    if (result < 0) fail("{}: cannot read it: {}", name_, reason());
    return values;
  }

 public:
  static constexpr int any_rank = -1;

 private:
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
  check(in.is_open(), "{}: cannot read it: {}", path, system_reason());
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
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

std::vector<std::string> Hdf5Reader::children(const std::string& group) const {
  const Quiet quiet;
  const Handle opened(H5Gopen2(file_, absolute(group).c_str(), H5P_DEFAULT), H5Gclose);
  check(opened.valid(), "{}: expected a group {}, found none", path_, absolute(group));
  std::vector<std::string> names;
  const auto take = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  // Other programs may have written the file without keeping the order.
  if (H5Literate(opened, H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, take, &names) < 0) {
    names.clear();
    const herr_t result = H5Literate(opened, H5_INDEX_NAME, H5_ITER_INC, nullptr, take, &names);
    if (result < 0) fail("{}: {}: cannot list it: {}", path_, absolute(group), reason());
  }
  return names;
}

Hdf5Reader::Source Hdf5Reader::dataset(const std::string& item) const {
  const std::string name = absolute(item);
  Handle opened(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  check(opened.valid(), "{}: expected a dataset {}, found none", path_, name);
  return {fmt::format("{}: {}", path_, name), std::move(opened), false, file_size_};
}

Hdf5Reader::Source Hdf5Reader::attribute(const std::string& item, const std::string& name) const {
  Handle opened(H5Aopen_by_name(file_, absolute(item).c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                H5Aclose);
  check(opened.valid(), "{}: expected an attribute {} of {}, found none", path_, name, absolute(item));
  return {fmt::format("{}: attribute {} of {}", path_, name, absolute(item)), std::move(opened), true,
          file_size_};
}

Points Hdf5Reader::read_points(const std::string& item) const {
  const Quiet quiet;
  const Source source = dataset(item);
  const std::vector<double> values = source.numbers(2);
  return Eigen::Map<const Points>(values.data(), static_cast<Eigen::Index>(source.shape()[0]),
                                  static_cast<Eigen::Index>(source.shape()[1]));
}
Vector Hdf5Reader::read_vector(const std::string& item) const {
  const Quiet quiet;
  const std::vector<double> values = dataset(item).numbers(1);
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}
Array Hdf5Reader::read_array(const std::string& item) const {
  const Quiet quiet;
  const Source source = dataset(item);
  return {{source.shape().begin(), source.shape().end()}, source.numbers(Source::any_rank)};
}
std::vector<std::int64_t> Hdf5Reader::read_integers(const std::string& item) const {
  const Quiet quiet;
  return dataset(item).integers(1);
}
std::string Hdf5Reader::read_text(const std::string& item) const {
  const Quiet quiet;
  return dataset(item).texts(0).front();
}
std::vector<std::string> Hdf5Reader::read_texts(const std::string& item) const {
  const Quiet quiet;
  return dataset(item).texts(1);
}
double Hdf5Reader::read_number(const std::string& item) const {
  const Quiet quiet;
  return dataset(item).numbers(0).front();
}
std::int64_t Hdf5Reader::read_integer(const std::string& item) const {
  const Quiet quiet;
  return dataset(item).integers(0).front();
}

bool Hdf5Reader::has_attribute(const std::string& item, const std::string& name) const {
  const Quiet quiet;
  return link_exists(file_, item) &&
         H5Aexists_by_name(file_, absolute(item).c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5Reader::attributes(const std::string& item) const {
  const Quiet quiet;
  const Handle owner(H5Oopen(file_, absolute(item).c_str(), H5P_DEFAULT), H5Oclose);
  check(owner.valid(), "{}: expected an item {}, found none", path_, absolute(item));
  std::vector<std::string> names;
  const auto take = [](hid_t, const char* name, const H5A_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  if (H5Aiterate2(owner, H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, take, &names) < 0) {
    names.clear();
    const herr_t result = H5Aiterate2(owner, H5_INDEX_NAME, H5_ITER_INC, nullptr, take, &names);
    if (result < 0) fail("{}: {}: cannot list its attributes: {}", path_, absolute(item), reason());
  }
  return names;
}

std::string Hdf5Reader::text_attribute(const std::string& item, const std::string& name) const {
  const Quiet quiet;
  return attribute(item, name).texts(0).front();
}
double Hdf5Reader::number_attribute(const std::string& item, const std::string& name) const {
  const Quiet quiet;
  return attribute(item, name).numbers(0).front();
}
std::int64_t Hdf5Reader::integer_attribute(const std::string& item, const std::string& name) const {
  const Quiet quiet;
  return attribute(item, name).integers(0).front();
}
std::vector<double> Hdf5Reader::numbers_attribute(const std::string& item, const std::string& name) const {
  const Quiet quiet;
  return attribute(item, name).numbers(1);
}
std::vector<std::int64_t> Hdf5Reader::integers_attribute(const std::string& item,
                                                         const std::string& name) const {
  const Quiet quiet;
  return attribute(item, name).integers(1);
}
std::vector<std::string> Hdf5Reader::texts_attribute(const std::string& item, const std::string& name) const {
  const Quiet quiet;
  return attribute(item, name).texts(1);
}

}  // namespace s2nnds
