// SPDX-License-Identifier: BSD-3-Clause
#include <matio.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/core/hdf5.h"
#include "s2nnds/core/printable.h"
#include "s2nnds/data/matlab_sizes.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/data/recording.h"

namespace s2nnds {
namespace {

// libmatio's complaints, instead of on stderr. It goes on after many of them with whatever it has read, so
// that a damaged file looks like a sound one with wrong numbers: every complaint counts as an error.
thread_local std::string complaint;

// matio 1.5.28 made `message` const: a template serves both.
template <typename Text>
void keep_complaint(int /*level*/, Text* message) {
  if (complaint.empty()) complaint = message != nullptr ? message : "no memory";
}

class ComplaintScope {
 public:
  ComplaintScope() {
    complaint.clear();
    Mat_LogInitFunc("s2nnds", keep_complaint);
  }
  ~ComplaintScope() { Mat_LogClose(); }
  ComplaintScope(const ComplaintScope&) = delete;
  ComplaintScope& operator=(const ComplaintScope&) = delete;
};

// Whether the version in the header is that of MATLAB 7.3, which is HDF5 behind 512 bytes of text.
bool is_hdf5(std::string_view bytes) {
  const std::string_view version = bytes.substr(std::min<std::size_t>(bytes.size(), 124), 4);
  return version == std::string_view("\x00\x02IM", 4) || version == std::string_view("\x02\x00MI", 4);
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

struct CloseFile {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

class MatlabFile {
 public:
  // `expected` completes every message: what the caller wants to find.
  MatlabFile(const std::string& path, std::string expected) : path_(path), expected_(std::move(expected)) {
    check_readable(path);
    const std::string bytes = bytes_of(path);
    file_size_ = static_cast<double>(bytes.size());
    if (is_hdf5(bytes)) {
      const Hdf5Reader whole(path);  // says what is wrong, where matio prints it
    } else {
      check_matlab_sizes(bytes, path_, expected_);
    }
    file_.reset(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
    check(file_ != nullptr, "{}: found no MATLAB file; expected {}", path_, expected_);
    const mat_ft version = Mat_GetVersion(file_.get());
    check(version == MAT_FT_MAT5 || version == MAT_FT_MAT73,
          "{}: found no MATLAB 5 to 7.3 file (another version, or no MATLAB file at all); expected {}", path_,
          expected_);
  }

  // The variable, or null if the file has none of this name.
  matvar_t* read(const char* name) {
    Mat_Rewind(file_.get());
    variables_.emplace_back(Mat_VarRead(file_.get(), name));
    check(complaint.empty(), "{}: found damaged or truncated data ({}); expected {}", path_,
          first_line(complaint), expected_);
    return variables_.back().get();
  }

  // The cell array `name`.
  matvar_t* read_cells(const char* name) {
    matvar_t* const cells = read(name);
    check(cells != nullptr, "{}: found {}; expected {}", path_, listing(), expected_);
    check(cells->class_type == MAT_C_CELL && cells->data != nullptr,
          "{}: found '{}' that is not a cell array; expected {}", path_, name, expected_);
    return cells;
  }

  // A real matrix of doubles. MATLAB stores columns one after another, so that [rows, columns] reads as
  // [columns, rows] here: one sample a row.
  Points matrix(const matvar_t* variable, const std::string& where) const {
    const bool real = variable != nullptr && variable->class_type == MAT_C_DOUBLE &&
                      variable->data_type == MAT_T_DOUBLE && variable->isComplex == 0 &&
                      variable->rank == 2 && variable->data != nullptr;
    check(real, "{}: found no real matrix of doubles; expected {}", where, expected_);
    const auto rows = static_cast<Eigen::Index>(variable->dims[0]);
    const auto columns = static_cast<Eigen::Index>(variable->dims[1]);
    // As doubles: the product of damaged sides may be more than an integer holds.
    check(static_cast<double>(variable->nbytes) ==
              static_cast<double>(rows) * static_cast<double>(columns) * sizeof(double),
          "{}: found {} bytes for [{}, {}] doubles; expected {}", where, variable->nbytes, rows, columns,
          expected_);
    // libmatio believes a damaged size. Deflate shrinks 1,032 bytes to one at best.
    check(static_cast<double>(variable->nbytes) <= 1032.0 * file_size_,
          "{}: found [{}, {}] doubles, more than the file of {} bytes holds; expected {}", where, rows,
          columns, file_size_, expected_);
    return Eigen::Map<const Points>(static_cast<const double*>(variable->data), columns, rows);
  }

 private:
  static std::string first_line(const std::string& text) {
    return printable(text.substr(0, text.find('\n')));
  }

  std::string listing() {
    std::size_t count = 0;
    const auto names = Mat_GetDir(file_.get(), &count);
    if (names == nullptr || count == 0) return "no variables (an empty or truncated file, or no MATLAB file)";
    std::string list = "the variable(s)";
    for (std::size_t i = 0; i < count; ++i)
      list += fmt::format("{} '{}'", i == 0 ? "" : ",", printable(names[i]));
    return list;
  }

  std::string path_;
  std::string expected_;
  double file_size_ = 0.0;  // bytes
  ComplaintScope scope_;
  std::unique_ptr<mat_t, CloseFile> file_;
  std::vector<std::unique_ptr<matvar_t, FreeVariable>> variables_;
};

std::size_t count(const matvar_t* cells) {
  std::size_t product = 1;
  for (int i = 0; i < cells->rank; ++i) product *= cells->dims[i];
  return product;
}

Vector as_vector(const Points& points) { return Eigen::Map<const Vector>(points.data(), points.size()); }

// Whether the rows of a ds-opt recording are positions above velocities: [2n, M] with n >= 2.
bool has_velocities(Eigen::Index rows) { return rows >= 4 && rows % 2 == 0; }

double time_step(MatlabFile& file, const std::string& path) {
  const double usual = 0.01;  // s, where the file does not say
  const matvar_t* const variable = file.read("dt");
  if (variable == nullptr) return usual;
  const Points dt = file.matrix(variable, path + ": dt");
  check(dt.size() == 1 && dt(0) > 0, "{}: dt: found {} value(s), the first {}; expected one time step > 0 s",
        path, dt.size(), dt.size() > 0 ? double(dt(0)) : 0.0);
  return dt(0);
}

// The numbers of a real matrix of any class as doubles: [columns, rows], as matrix().
template <typename Number>
Points converted(const matvar_t& variable) {
  const auto rows = static_cast<Eigen::Index>(variable.dims[0]);
  const auto columns = static_cast<Eigen::Index>(variable.dims[1]);
  const auto* const numbers = static_cast<const Number*>(variable.data);
  Points made(columns, rows);
  for (Eigen::Index i = 0; i < made.size(); ++i) made.data()[i] = static_cast<double>(numbers[i]);
  return made;
}

Points any_matrix(const matvar_t* variable, const std::string& where, const MatlabFile& file) {
  const bool real = variable != nullptr && variable->isComplex == 0 && variable->rank == 2 &&
                    variable->data != nullptr && variable->class_type != MAT_C_DOUBLE;
  const auto holds = [&](matio_types type, std::size_t size) {
    return real && variable->data_type == type &&
           static_cast<double>(variable->nbytes) == static_cast<double>(variable->dims[0]) *
                                                        static_cast<double>(variable->dims[1]) *
                                                        static_cast<double>(size);
  };
  if (holds(MAT_T_SINGLE, 4)) return converted<float>(*variable);
  if (holds(MAT_T_INT32, 4)) return converted<std::int32_t>(*variable);
  if (holds(MAT_T_INT64, 8)) return converted<std::int64_t>(*variable);
  if (holds(MAT_T_UINT32, 4)) return converted<std::uint32_t>(*variable);
  if (holds(MAT_T_UINT64, 8)) return converted<std::uint64_t>(*variable);
  return file.matrix(variable, where);
}

// Recordings in variables or fields that have names.
class NamedMatrices {
 public:
  NamedMatrices(const std::string& path, const TableOptions& options)
      : path_(path),
        options_(options),
        file_(path, "matrices named time and position, or as data.columns says, [M, n] or [n, M]") {}

  void read(RecordingSet& set) {
    const std::string& index = options_.columns.index;
    if (index.empty()) {
      read_variables(set);
    } else {
      read_members(set, index);
    }
  }

 private:
  // The variable or field of this name, or null.
  using Find = std::function<const matvar_t*(const std::string& name)>;

  // One demonstration, or one a cell where the positions are a cell array.
  void read_variables(RecordingSet& set) {
    const Names position =
        names_of(options_.columns.position, {"position", "positions", "pos", "x", "xyz", "q"});
    const matvar_t* const first = any(position, [this](const std::string& name) { return variable(name); });
    const bool many = first != nullptr && first->class_type == MAT_C_CELL;
    const std::size_t parts = many ? count(first) : 1;
    for (std::size_t k = 0; k < parts; ++k) {
      const auto find = [&](const std::string& name) -> const matvar_t* {
        matvar_t* const found = variable(name);
        if (found == nullptr || found->class_type != MAT_C_CELL) return found;
        return k < count(found) ? Mat_VarGetCell(found, static_cast<int>(k)) : nullptr;
      };
      add(set, find, many ? fmt::format("{}: cell {}", path_, k) : path_);
    }
  }

  // One demonstration a structure of a structure array, or of a cell array.
  void read_members(RecordingSet& set, const std::string& index) {
    matvar_t* const members = variable(index);
    const bool cells = members != nullptr && members->class_type == MAT_C_CELL;
    check(members != nullptr && members->data != nullptr && (cells || members->class_type == MAT_C_STRUCT),
          "{}: found no cell array or structure array '{}'; expected the one that data.columns.index names",
          path_, index);
    for (std::size_t k = 0; k < count(members); ++k) {
      const std::string where = fmt::format("{}: {}({})", path_, index, k + 1);
      matvar_t* const one = cells ? Mat_VarGetCell(members, static_cast<int>(k)) : members;
      check(one != nullptr && one->class_type == MAT_C_STRUCT && (!cells || count(one) == 1),
            "{}: found no structure; expected one with the fields of a demonstration", where);
      add(
          set,
          [&](const std::string& name) -> const matvar_t* {
            return Mat_VarGetStructFieldByName(one, name.c_str(), cells ? 0 : k);
          },
          where);
    }
  }

  using Names = std::vector<std::string>;
  static Names names_of(const Names& wanted, const Names& usual) { return wanted.empty() ? usual : wanted; }

  const matvar_t* any(const Names& names, const Find& find) const {
    for (const std::string& name : names)
      if (const matvar_t* const found = find(name); found != nullptr) return found;
    return nullptr;
  }

  matvar_t* variable(const std::string& name) {
    const auto [place, is_new] = read_.try_emplace(name, nullptr);
    if (is_new) place->second = file_.read(name.c_str());
    return place->second;
  }

  // The matrices of these names, samples in rows, side by side; of `usual` names the first that is there. `samples`:
  // 0 where not known.
  Points matrices(const Find& find, const Names& wanted, const Names& usual, Eigen::Index samples,
                  std::string_view key, const std::string& where) const {
    if (wanted.empty()) {
      const matvar_t* const found = any(usual, find);
      check(found != nullptr, "{}: found no '{}'; expected it, or another name in data.columns.{}", where,
            usual.front(), key);
      return upright(any_matrix(found, where, file_), samples, key, where);
    }
    Points all;
    for (const std::string& name : wanted) {
      const matvar_t* const found = find(name);
      check(found != nullptr, "{}: found no '{}'; expected it as data.columns.{} says", where, name, key);
      const Points one = upright(any_matrix(found, where + ": " + name, file_),
                                 samples > 0 ? samples : all.rows(), key, where);
      const Eigen::Index before = all.cols();
      all.conservativeResize(one.rows(), before + one.cols());
      all.rightCols(one.cols()) = one;
    }
    return all;
  }

  // [M, n] of a matrix that may be written either way; where the number of samples is not known, the longer side.
  static Points upright(Points m, Eigen::Index samples, std::string_view key, const std::string& where) {
    if (samples == 0) samples = std::max(m.rows(), m.cols());
    check(m.rows() == samples || m.cols() == samples, "{}: found a {} of [{}, {}]; expected {} samples",
          where, key, m.cols(), m.rows(), samples);
    // matrix() has exchanged the sides.
    if (m.cols() == samples) return m.transpose();
    return m;
  }

  void add(RecordingSet& set, const Find& find, const std::string& where) const {
    const ColumnOptions& wanted = options_.columns;
    const auto as_names = [](const std::string& name) { return name.empty() ? Names{} : Names{name}; };
    Recording r{where, "", 0, {}, {}, {}};
    if (options_.rate <= 0) {
      r.time_column = wanted.time.empty() ? "time" : wanted.time;
      const Points time =
          matrices(find, as_names(wanted.time), {"time", "t", "times", "timestamps"}, 0, "time", where);
      check(time.cols() == 1, "{}: found times of [{}, {}]; expected one a sample", where, time.rows(),
            time.cols());
      r.time = time.col(0);
    }
    r.position = matrices(find, wanted.position, {"position", "positions", "pos", "x", "xyz", "q"},
                          r.time.size(), "position", where);
    if (options_.rate > 0)
      r.time = Vector::LinSpaced(r.samples(), 0, static_cast<double>(r.samples() - 1) / options_.rate);
    const Names velocity = {"velocity", "velocities", "vel"};
    const bool none = wanted.velocity == Names{"none"};
    if (!none && (!wanted.velocity.empty() || any(velocity, find) != nullptr))
      r.velocity = matrices(find, wanted.velocity, velocity, r.samples(), "velocity", where);
    add_orientation(set, r, find);
    set.recordings.push_back(std::move(r));
  }

  // Quaternions [M, 4], or rotation matrices row by row [M, 9].
  void add_orientation(RecordingSet& set, Recording& r, const Find& find) const {
    const ColumnOptions& wanted = options_.columns;
    const Names& named = wanted.rotation.empty() ? wanted.quaternion : wanted.rotation;
    const Names usual = {"quaternion", "quaternions", "quat", "orientation", "rotation"};
    const bool found = any(names_of(named, usual), find) != nullptr;
    set.has_orientations = set.has_orientations || found;
    if (options_.state != "pose") return;
    check(found, "{}: {}", r.where, kNoOrientation);
    const std::string_view key = wanted.rotation.empty() ? "quaternion" : "rotation";
    r.orientation = matrices(find, named, usual, r.samples(), key, r.where);
    const Eigen::Index columns = r.orientation.cols();
    check(columns == 4 || columns == 9,
          "{}: found orientations of {} numbers; expected 4 of a quaternion or 9 of a rotation matrix",
          r.where, columns);
  }

  std::string path_;
  const TableOptions& options_;
  MatlabFile file_;
  std::map<std::string, matvar_t*> read_;
};

}  // namespace

RecordingSet read_mat(const std::vector<std::string>& paths, const TableOptions& options) {
  check(!paths.empty(), "mat: found no files; expected at least one (data.files)");
  RecordingSet set{stem(paths.front()), ""};
  if (options.rate > 0) set.time_unit = 1;
  for (const std::string& path : paths) NamedMatrices(path, options).read(set);
  return set;
}

RecordingSet read_lasa(const std::string& path) {
  MatlabFile file(path, "a LASA file, demos{k} with fields pos [n, M], t [1, M] and vel [n, M]");
  matvar_t* const demos = file.read_cells("demos");
  RecordingSet set{.name = stem(path), .unit = "mm", .time_unit = 1};
  for (std::size_t k = 0; k < count(demos); ++k) {
    const std::string where = fmt::format("{}: demonstration {}", path, k);
    matvar_t* const demo = Mat_VarGetCell(demos, static_cast<int>(k));
    const bool is_struct = demo != nullptr && demo->class_type == MAT_C_STRUCT && count(demo) == 1;
    const auto field = [&](const char* name) {
      return file.matrix(is_struct ? Mat_VarGetStructFieldByName(demo, name, 0) : nullptr,
                         where + ": " + name);
    };
    set.recordings.push_back({where, "t", 0, as_vector(field("t")), field("pos"), field("vel")});
  }
  return set;
}

RecordingSet read_ds_opt(const std::string& path) {
  MatlabFile file(path, "a ds-opt file, data{k} of [2n, M] doubles, positions above velocities");
  matvar_t* const data = file.read_cells("data");
  const double dt = time_step(file, path);
  RecordingSet set{.name = stem(path), .unit = "m", .time_unit = 1};
  for (std::size_t k = 0; k < count(data); ++k) {
    const std::string where = fmt::format("{}: demonstration {}", path, k);
    const Points all = file.matrix(Mat_VarGetCell(data, static_cast<int>(k)), where);
    const Eigen::Index n = has_velocities(all.cols()) ? all.cols() / 2 : all.cols();
    const Vector time = dt * Vector::LinSpaced(all.rows(), 0.0, static_cast<double>(all.rows() - 1));
    set.recordings.push_back({where, "dt", 0, time, all.leftCols(n), all.rightCols(all.cols() - n)});
  }
  return set;
}

}  // namespace s2nnds
