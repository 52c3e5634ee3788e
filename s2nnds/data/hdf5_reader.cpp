#include <hdf5.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/data/recording.h"

namespace s2nnds {
namespace {

// Keeps HDF5 from printing its error stack: the library prints nothing.
class QuietErrors {
 public:
  QuietErrors() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

// An open HDF5 object; negative when it could not be opened.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  hid_t id() const { return id_; }
  bool ok() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

constexpr const char* kExpected =
    "/demonstrations/K with time [M], position [M, n] and, optionally, velocity [M, n]";

// A dataset of numbers of rank 1 or 2 as [rows, columns]; rank 1 counts as one column.
Points read_dataset(hid_t group, const char* name, const std::string& where) {
  const Handle dataset(H5Dopen2(group, name, H5P_DEFAULT), H5Dclose);
  check(dataset.ok(), "{}: found no dataset '{}'; expected {}", where, name, kExpected);
  const Handle type(H5Dget_type(dataset.id()), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.id());
  check(kind == H5T_FLOAT || kind == H5T_INTEGER, "{}/{}: found data that are not numbers; expected {}",
        where, name, kExpected);
  const Handle space(H5Dget_space(dataset.id()), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.id());
  check(rank == 1 || rank == 2, "{}/{}: found rank {}; expected {}", where, name, rank, kExpected);
  hsize_t size[2] = {0, 1};
  H5Sget_simple_extent_dims(space.id(), size, nullptr);
  Points values(static_cast<Eigen::Index>(size[0]), static_cast<Eigen::Index>(size[1]));
  check(H5Dread(dataset.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
        "{}/{}: found data that cannot be read (a damaged or truncated file); expected {}", where, name,
        kExpected);
  return values;
}

// The group's members by number: 2 before 10.
std::vector<std::string> members(hid_t group) {
  H5G_info_t info{};
  if (H5Gget_info(group, &info) < 0) return {};
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const auto at = [&](char* text, std::size_t size) {
      return H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, text, size, H5P_DEFAULT);
    };
    const ssize_t length = at(nullptr, 0);
    if (length < 0) continue;
    std::string name(static_cast<std::size_t>(length), '\0');
    at(name.data(), name.size() + 1);
    names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
    return std::pair(a.size(), a) < std::pair(b.size(), b);
  });
  return names;
}

Demonstration read_demonstration(hid_t parent, const std::string& name, std::int64_t stride,
                                 const std::string& where) {
  const Handle group(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose);
  check(group.ok(), "{}: found no group; expected {}", where, kExpected);
  const Points time = read_dataset(group.id(), "time", where);
  check(time.rows() == 1 || time.cols() == 1, "{}/time: found shape [{}, {}]; expected {}", where,
        time.rows(), time.cols(), kExpected);
  const Points position = read_dataset(group.id(), "position", where);
  Points velocity;
  if (H5Lexists(group.id(), "velocity", H5P_DEFAULT) > 0)
    velocity = read_dataset(group.id(), "velocity", where);
  return make_demonstration(Eigen::Map<const Vector>(time.data(), time.size()), position, velocity, stride,
                            where);
}

}  // namespace

DemonstrationSet read_hdf5(const std::string& path, std::int64_t stride) {
  check_readable(path);
  const QuietErrors quiet;
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  check(file.ok(), "{}: found no HDF5 file, or a truncated one; expected {}", path, kExpected);
  const Handle group(H5Gopen2(file.id(), "demonstrations", H5P_DEFAULT), H5Gclose);
  check(group.ok(), "{}: found no group /demonstrations; expected {}", path, kExpected);
  DemonstrationSet set{stem(path), "", {}};
  for (const std::string& name : members(group.id())) {
    set.demonstrations.push_back(
        read_demonstration(group.id(), name, stride, fmt::format("{}: /demonstrations/{}", path, name)));
  }
  check_demonstrations(set, path);
  return set;
}

}  // namespace s2nnds
