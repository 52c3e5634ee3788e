// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/point_cloud_file.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"
#include "s2nnds/data/delimited_text.h"
#include "s2nnds/problem/file_text.h"

namespace s2nnds {
namespace {

using Words = std::vector<std::string_view>;

// One number of a binary record.
struct Field {
  std::string name;
  char kind;         // 'F' floating point, 'I' and 'U' integers
  std::size_t size;  // bytes: 1, 2, 4 or 8
};

template <typename T>
double read_as(const char* from, bool swap) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), from, sizeof(T));
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<T>(bytes));
}

double read_field(const Field& field, const char* from, bool swap) {
  if (field.kind == 'F') return field.size == 4 ? read_as<float>(from, swap) : read_as<double>(from, swap);
  const bool is_signed = field.kind == 'I';
  switch (field.size) {
    case 1:
      return is_signed ? read_as<std::int8_t>(from, swap) : read_as<std::uint8_t>(from, swap);
    case 2:
      return is_signed ? read_as<std::int16_t>(from, swap) : read_as<std::uint16_t>(from, swap);
    case 4:
      return is_signed ? read_as<std::int32_t>(from, swap) : read_as<std::uint32_t>(from, swap);
    default:
      return is_signed ? read_as<std::int64_t>(from, swap) : read_as<std::uint64_t>(from, swap);
  }
}

// The head of a PLY or a PCD file.
struct Head {
  std::vector<Field> fields;
  std::int64_t count = -1;  // of points
  std::string data;         // ascii, binary
  bool big_endian = false;
  std::size_t size = 0;  // bytes, after which the points begin
};

std::optional<std::size_t> column_of(const std::vector<std::string>& names, Eigen::Index axis) {
  const std::string numbered = fmt::format("x{}", axis + 1);
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (names[k] == numbered || (axis < 3 && names[k] == std::string(1, "xyz"[axis]))) return k;
  }
  return std::nullopt;
}

// The columns that hold the coordinates: of a file in space also where the problem is in the plane.
std::vector<std::size_t> columns_of(const std::vector<std::string>& names, Eigen::Index dimension,
                                    const std::string& where) {
  std::vector<std::size_t> columns;
  for (Eigen::Index i = 0; i < std::max<Eigen::Index>(dimension, 3); ++i) {
    const auto column = column_of(names, i);
    if (column) columns.push_back(*column);
    check(column || i >= dimension, "{}: found the columns {}, expected {} coordinates such as x, y", where,
          printable(fmt::format("{}", fmt::join(names, ", ")).substr(0, 80)), dimension);
    if (!column) break;
  }
  return columns;
}

// Rows of numbers as points: in the plane without the height, if it is one for all of them.
Points points_of(const std::vector<std::vector<double>>& rows, Eigen::Index dimension,
                 const std::string& name) {
  check(!rows.empty(), "{}: found no points, expected at least one", name);
  Points points(static_cast<Eigen::Index>(rows.size()), dimension);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::vector<double>& row = rows[k];
    check(row.size() == rows[0].size(), "{}: point {} has {} coordinates, expected {}", name, k, row.size(),
          rows[0].size());
    const bool in_space = dimension == 2 && row.size() == 3;
    check(static_cast<Eigen::Index>(row.size()) == dimension || in_space,
          "{}: found points of {} coordinates, expected {}", name, row.size(), dimension);
    check(!in_space || row[2] == rows[0][2],
          "{}: found points at the heights {} and {}, expected one height, since the problem is in the plane",
          name, rows[0][2], row[2]);
    for (Eigen::Index i = 0; i < dimension; ++i) {
      points(static_cast<Eigen::Index>(k), i) = row[static_cast<std::size_t>(i)];
    }
    check(points.row(static_cast<Eigen::Index>(k)).allFinite(),
          "{}: a coordinate of point {} is not a finite number", name, k);
  }
  return points;
}

std::vector<std::string> names_of(const std::vector<Field>& fields) {
  std::vector<std::string> names;
  for (const Field& field : fields) names.push_back(field.name);
  return names;
}

// The points behind a head, as text or binary.
Points read_records(const std::string& bytes, const std::string& name, const Head& head,
                    Eigen::Index dimension, bool leave_out_empty) {
  const std::vector<std::size_t> columns = columns_of(names_of(head.fields), dimension, name);
  std::vector<std::vector<double>> rows;
  const auto keep = [&](const std::vector<double>& all) {
    std::vector<double> row;
    for (const std::size_t column : columns) row.push_back(all[column]);
    const bool empty = std::all_of(row.begin(), row.end(), [](double x) { return std::isnan(x); });
    if (!empty || !leave_out_empty) rows.push_back(std::move(row));
  };
  std::vector<double> all(head.fields.size());
  if (head.data == "ascii") {
    FileText text(std::string_view(bytes).substr(head.size), name + " behind its head");
    Words words;
    for (std::int64_t k = 0; k < head.count; ++k) {
      check(text.next(words) && words.size() >= all.size(), "{}: found {} whole points, expected {}", name, k,
            head.count);
      for (std::size_t i = 0; i < all.size(); ++i) {
        all[i] = words[i] == "nan" ? std::numeric_limits<double>::quiet_NaN() : text.number(words[i]);
      }
      keep(all);
    }
    return points_of(rows, dimension, name);
  }
  std::size_t stride = 0;
  for (const Field& field : head.fields) stride += field.size;
  check((bytes.size() - head.size) / stride >= static_cast<std::size_t>(head.count),
        "{}: found {} bytes of points, expected {} of {} each", name, bytes.size() - head.size, head.count,
        stride);
  const char* at = bytes.data() + head.size;
  for (std::int64_t k = 0; k < head.count; ++k) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = read_field(head.fields[i], at, head.big_endian);
      at += head.fields[i].size;
    }
    keep(all);
  }
  return points_of(rows, dimension, name);
}

Field ply_field(const Words& words, const FileText& text) {
  static const std::map<std::string_view, std::pair<char, std::size_t>> kTypes{
      {"char", {'I', 1}},  {"uchar", {'U', 1}},  {"short", {'I', 2}},   {"ushort", {'U', 2}},
      {"int", {'I', 4}},   {"uint", {'U', 4}},   {"float", {'F', 4}},   {"double", {'F', 8}},
      {"int8", {'I', 1}},  {"uint8", {'U', 1}},  {"int16", {'I', 2}},   {"uint16", {'U', 2}},
      {"int32", {'I', 4}}, {"uint32", {'U', 4}}, {"float32", {'F', 4}}, {"float64", {'F', 8}}};
  const auto type = words.size() == 3 ? kTypes.find(words[1]) : kTypes.end();
  if (type == kTypes.end())
    fail("{}: expected a property of a vertex such as 'property float x'", text.where());
  return {std::string(words[2]), type->second.first, type->second.second};
}

Points read_ply(const std::string& bytes, const std::string& name, Eigen::Index dimension) {
  FileText text(bytes, name);
  Head head;
  Words words;
  check(text.next(words) && words[0] == "ply", "{}: expected PLY, which begins with the line 'ply'", name);
  std::string element;
  bool ended = false;
  while (!ended && text.next(words)) {
    ended = words[0] == "end_header";
    if (words[0] == "format" && words.size() >= 2) {
      head.data = words[1] == "ascii" ? "ascii" : "binary";
      head.big_endian = words[1] == "binary_big_endian";
    }
    if (words[0] == "element" && words.size() == 3) {
      element = words[1];
      check(head.count >= 0 || element == "vertex", "{}: found the element {} first, expected vertex",
            text.where(), shown(element));
      if (element == "vertex") head.count = text.integer(words[2]);
    }
    if (words[0] == "property" && element == "vertex") head.fields.push_back(ply_field(words, text));
  }
  check(ended && head.count >= 0 && !head.data.empty() && !head.fields.empty(),
        "{}: expected a PLY head with format, element vertex, properties and end_header", name);
  head.size = text.position();
  return read_records(bytes, name, head, dimension, false);
}

Points read_pcd(const std::string& bytes, const std::string& name, Eigen::Index dimension) {
  FileText text(bytes, name);
  Head head;
  std::map<std::string, std::vector<std::string>> entries;
  Words words;
  while (head.data.empty() && text.next(words)) {
    std::vector<std::string>& entry = entries[std::string(words[0])];
    entry.assign(words.begin() + 1, words.end());
    if (words[0] == "DATA" && !entry.empty()) head.data = entry[0];
  }
  const std::vector<std::string>&names = entries["FIELDS"], &sizes = entries["SIZE"],
        &kinds = entries["TYPE"];
  check(!names.empty() && sizes.size() == names.size() && kinds.size() == names.size() &&
            entries["POINTS"].size() == 1,
        "{}: expected a PCD head with FIELDS, SIZE, TYPE, POINTS and DATA", name);
  check(head.data == "ascii" || head.data == "binary",
        "{}: found DATA '{}', expected ascii or binary (pcl_convert_pcd_ascii_binary makes them)", name,
        shown(head.data));
  head.count = text.integer(entries["POINTS"][0]);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::int64_t size = text.integer(sizes[k]);
    const std::int64_t repeats =
        entries["COUNT"].size() == names.size() ? text.integer(entries["COUNT"][k]) : 1;
    check((size == 1 || size == 2 || size == 4 || size == 8) &&
              (kinds[k] == "I" || kinds[k] == "U" || (kinds[k] == "F" && size >= 4)),
          "{}: found the field {} of size {} and type {}, expected sizes 1, 2, 4 or 8 and types I, U or F",
          name, shown(names[k]), size, shown(kinds[k]));
    check(repeats >= 1 && static_cast<std::size_t>(repeats) <= bytes.size() - head.fields.size(),
          "{}: found {} numbers a point in the field {}, expected at least 1 and no more than the file has",
          name, repeats, shown(names[k]));
    for (std::int64_t i = 0; i < repeats; ++i) {
      head.fields.push_back({i == 0 ? names[k] : "", kinds[k][0], static_cast<std::size_t>(size)});
    }
  }
  check(head.count >= 0, "{}: found POINTS {}, expected at least 0", name, head.count);
  head.size = text.position();
  return read_records(bytes, name, head, dimension, true);
}

Points read_npy(const std::string& bytes, const std::string& name, Eigen::Index dimension) {
  check(bytes.size() > 12 && bytes.starts_with("\x93NUMPY"), "{}: expected NPY, found another format", name);
  const bool first_version = bytes[6] == 1;
  const std::size_t length = first_version
                                 ? static_cast<std::size_t>(read_as<std::uint16_t>(bytes.data() + 8, false))
                                 : static_cast<std::size_t>(read_as<std::uint32_t>(bytes.data() + 8, false));
  const std::size_t start = (first_version ? 10 : 12) + length;
  check(start <= bytes.size(), "{}: ends within its head, expected a whole NPY file", name);
  const std::string described = bytes.substr(first_version ? 10 : 12, length);
  const bool single = described.find("<f4") != std::string::npos;
  check((single || described.find("<f8") != std::string::npos) &&
            described.find("'fortran_order': False") != std::string::npos,
        "{}: found {}, expected float32 or float64, row by row", name, printable(described.substr(0, 80)));
  const std::size_t open = described.find("'shape': (");
  check(open != std::string::npos, "{}: expected a shape in the NPY head", name);
  FileText shape(std::string_view(described).substr(open + 10, described.find(')', open) - open - 10), name,
                 ",");
  Words words;
  check(shape.next(words) && words.size() == 2,
        "{}: found an array of other than two indices, expected [N, {}]", name, dimension);
  const std::int64_t rows = shape.integer(words[0]), columns = shape.integer(words[1]);
  const std::size_t size = single ? 4 : 8;
  check(
      rows >= 0 && columns >= 1 &&
          (bytes.size() - start) / size / static_cast<std::size_t>(columns) >= static_cast<std::size_t>(rows),
      "{}: found {} bytes of numbers, expected {} x {}", name, bytes.size() - start, rows, columns);
  std::vector<std::vector<double>> points;
  const char* at = bytes.data() + start;
  for (std::int64_t k = 0; k < rows; ++k) {
    std::vector<double>& point = points.emplace_back();
    for (std::int64_t i = 0; i < columns; ++i, at += size) {
      point.push_back(single ? read_as<float>(at, false) : read_as<double>(at, false));
    }
  }
  return points_of(points, dimension, name);
}

Points read_text(const std::string& bytes, const std::string& name, Eigen::Index dimension) {
  FileText text(bytes, name, ",;");
  Words words;
  std::vector<std::vector<double>> rows;
  std::vector<std::size_t> columns;
  bool first = true;
  while (text.next(words)) {
    const bool header = first && !is_number(words[0]);
    first = false;
    if (header) {
      columns = columns_of(std::vector<std::string>(words.begin(), words.end()), dimension, text.where());
      continue;
    }
    std::vector<double>& row = rows.emplace_back();
    if (columns.empty()) {
      for (const std::string_view word : words) row.push_back(text.number(word));
    }
    for (const std::size_t column : columns) {
      check(column < words.size(), "{}: found {} columns, expected {}", text.where(), words.size(),
            column + 1);
      row.push_back(text.number(words[column]));
    }
  }
  return points_of(rows, dimension, name);
}

}  // namespace

Points read_point_cloud(const std::string& bytes, const std::string& name, Eigen::Index dimension) {
  const std::string ending = ending_of(name);
  if (ending == "ply") return read_ply(bytes, name, dimension);
  if (ending == "pcd") return read_pcd(bytes, name, dimension);
  if (ending == "npy") return read_npy(bytes, name, dimension);
  check(ending == "csv" || ending == "txt" || ending == "xyz",
        "{}: expected points with the ending .csv, .txt, .xyz, .ply, .pcd or .npy", name);
  return read_text(bytes, name, dimension);
}

}  // namespace s2nnds
