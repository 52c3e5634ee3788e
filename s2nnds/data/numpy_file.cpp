// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/numpy_file.h"

#include <fmt/ranges.h>
#include <zip.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <string_view>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"
#include "s2nnds/data/recording.h"

namespace s2nnds {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr zip_uint64_t kMostBytes = zip_uint64_t{1} << 34;  // of one array in an archive
constexpr std::size_t kMostAxes = 64;                       // as NumPy allows

struct NpyHeader {
  char type = 0;  // f, i, u
  std::size_t bytes = 0;
  bool big_endian = false;
  bool fortran_order = false;
  std::vector<Eigen::Index> shape;
};

// What follows `key` and a colon in a Python dictionary, without the blanks before it.
std::string_view value_of(std::string_view dictionary, std::string_view key, const std::string& where) {
  const auto place = dictionary.find(key);
  const auto colon = place == std::string_view::npos ? place : dictionary.find(':', place);
  check(colon != std::string_view::npos, "{}: found no {} in the header; expected an .npy file", where, key);
  std::string_view value = dictionary.substr(colon + 1);
  value.remove_prefix(std::min(value.find_first_not_of(' '), value.size()));
  return value;
}

void read_type(std::string_view value, NpyHeader& header, const std::string& where) {
  const std::string_view text = value.substr(0, std::min<std::size_t>(value.find_first_of(",}"), 40));
  const bool simple = value.size() >= 5 && value[0] == '\'' && value[4] == '\'';
  if (simple) {
    header.big_endian = value[1] == '>';
    header.type = value[2];
    header.bytes = static_cast<std::size_t>(value[3] - '0');
  }
  const bool real = header.type == 'f' && (header.bytes == 4 || header.bytes == 8);
  const bool integer = (header.type == 'i' || header.type == 'u') &&
                       (header.bytes == 1 || header.bytes == 2 || header.bytes == 4 || header.bytes == 8);
  check(simple && std::string_view("<>|=").find(value[1]) != std::string_view::npos && (real || integer),
        "{}: found numbers of type {}; expected f4, f8 or integers", where, printable(std::string(text)));
}

void read_shape(std::string_view value, NpyHeader& header, const std::string& where) {
  check(value.starts_with('('), "{}: found no shape in the header; expected an .npy file", where);
  value.remove_prefix(1);
  while (true) {
    value.remove_prefix(std::min(value.find_first_not_of(" ,"), value.size()));
    if (value.starts_with(')')) return;
    Eigen::Index side = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), side);
    check(error == std::errc() && side >= 0, "{}: found a shape that cannot be read; expected an .npy file",
          where);
    check(header.shape.size() < kMostAxes, "{}: found a shape of more than {} axes; expected an .npy file",
          where, kMostAxes);
    header.shape.push_back(side);
    value.remove_prefix(static_cast<std::size_t>(end - value.data()));
  }
}

NpyHeader parse_header(std::string_view dictionary, const std::string& where) {
  NpyHeader header;
  read_type(value_of(dictionary, "'descr'", where), header, where);
  header.fortran_order = value_of(dictionary, "'fortran_order'", where).starts_with("True");
  read_shape(value_of(dictionary, "'shape'", where), header, where);
  return header;
}

template <typename T>
double number(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

double number(const NpyHeader& header, const char* bytes) {
  unsigned char ordered[8];
  std::memcpy(ordered, bytes, header.bytes);
  if (header.big_endian != (std::endian::native == std::endian::big))
    std::reverse(ordered, ordered + header.bytes);
  if (header.type == 'f') return header.bytes == 4 ? number<float>(ordered) : number<double>(ordered);
  const bool is_signed = header.type == 'i';
  switch (header.bytes) {
    case 1:
      return is_signed ? number<std::int8_t>(ordered) : number<std::uint8_t>(ordered);
    case 2:
      return is_signed ? number<std::int16_t>(ordered) : number<std::uint16_t>(ordered);
    case 4:
      return is_signed ? number<std::int32_t>(ordered) : number<std::uint32_t>(ordered);
    default:
      return is_signed ? number<std::int64_t>(ordered) : number<std::uint64_t>(ordered);
  }
}

// The place in Fortran order of the element at `place` in C order.
std::size_t fortran_place(std::size_t place, const std::vector<Eigen::Index>& shape) {
  std::size_t found = 0;
  for (std::size_t axis = shape.size(); axis-- > 0;) {
    const auto side = static_cast<std::size_t>(shape[axis]);
    std::size_t stride = 1;
    for (std::size_t before = 0; before < axis; ++before) stride *= static_cast<std::size_t>(shape[before]);
    found += place % side * stride;
    place /= side;
  }
  return found;
}

std::string read_bytes(const std::string& path) {
  check_readable(path);
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

std::string entry_bytes(zip_t* archive, zip_uint64_t index, const std::string& where) {
  zip_stat_t about;
  check(zip_stat_index(archive, index, 0, &about) == 0 && (about.valid & ZIP_STAT_SIZE) != 0,
        "{}: found a damaged entry; expected a whole .npz file", where);
  // As for HDF5: deflate shrinks 1,032 bytes to one at best.
  check(about.size <= kMostBytes && about.size <= 1032 * (about.comp_size + 1),
        "{}: found an entry of {} bytes; expected a whole .npz file", where, about.size);
  const std::unique_ptr<zip_file_t, Discard> file(zip_fopen_index(archive, index, 0));
  std::string bytes(static_cast<std::size_t>(about.size), '\0');
  const zip_int64_t read = file ? zip_fread(file.get(), bytes.data(), about.size) : -1;
  char after = 0;  // reading on to the end compares the checksum
  check(read == static_cast<zip_int64_t>(about.size) && zip_fread(file.get(), &after, 1) == 0,
        "{}: found damaged or truncated data; expected a whole .npz file", where);
  return bytes;
}

std::vector<std::pair<std::string, Array>> read_npz(const std::string& path) {
  int code = 0;
  const std::unique_ptr<zip_t, Discard> archive(zip_open(path.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &code));
  check(archive != nullptr,
        "{}: found no whole .npz file (a ZIP archive); expected one that numpy.savez wrote", path);
  std::vector<std::pair<std::string, Array>> arrays;
  const zip_int64_t count = zip_get_num_entries(archive.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    const char* const entry = zip_get_name(archive.get(), static_cast<zip_uint64_t>(i), 0);
    std::string name = entry != nullptr ? entry : "";
    if (!name.ends_with(".npy")) continue;
    name.resize(name.size() - 4);
    const std::string where = fmt::format("{}: {}", path, printable(name.substr(0, 80)));
    arrays.emplace_back(name,
                        parse_npy(entry_bytes(archive.get(), static_cast<zip_uint64_t>(i), where), where));
  }
  return arrays;
}

}  // namespace

Array parse_npy(const std::string& bytes, const std::string& where) {
  check(bytes.starts_with(kMagic) && bytes.size() >= 12,
        "{}: found no .npy file; expected one that numpy.save wrote", where);
  const int version = bytes[6];
  check(version >= 1 && version <= 3, "{}: found .npy format {}; expected 1 to 3", where, version);
  const std::size_t size_bytes = version == 1 ? 2 : 4;
  std::size_t size = 0;
  for (std::size_t i = size_bytes; i-- > 0;) size = 256 * size + static_cast<unsigned char>(bytes[8 + i]);
  const std::size_t begin = 8 + size_bytes + size;
  check(begin <= bytes.size(), "{}: found a truncated header; expected a whole .npy file", where);
  const NpyHeader header = parse_header(std::string_view(bytes).substr(8 + size_bytes, size), where);
  std::size_t count = 1;
  for (const Eigen::Index side : header.shape) {
    check(side == 0 || count <= bytes.size() / static_cast<std::size_t>(side),
          "{}: found shape [{}] in {} bytes; expected a whole .npy file", where,
          fmt::join(header.shape, ", "), bytes.size());
    count *= static_cast<std::size_t>(side);
  }
  check(bytes.size() - begin == count * header.bytes,
        "{}: found {} bytes for shape [{}] of {} bytes each; expected a whole .npy file", where,
        bytes.size() - begin, fmt::join(header.shape, ", "), header.bytes);
  Array array{header.shape, std::vector<double>(count)};
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t place = header.fortran_order ? fortran_place(i, header.shape) : i;
    array.values[i] = number(header, bytes.data() + begin + place * header.bytes);
  }
  return array;
}

std::vector<std::pair<std::string, Array>> read_numpy_file(const std::string& path) {
  if (!path.ends_with(".npz")) return {{"", parse_npy(read_bytes(path), path)}};
  check_readable(path);
  return read_npz(path);
}

}  // namespace s2nnds
