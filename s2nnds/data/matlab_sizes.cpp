// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/matlab_sizes.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr std::size_t kHeader = 128;  // bytes; the last four tell the version, and the order of bytes
constexpr int kDepth = 20;            // cells within cells, at most

// Kinds of elements.
constexpr std::uint32_t kInt8 = 1, kInt32 = 5, kUint32 = 6, kMatrix = 14, kCompressed = 15;
// Classes of arrays; from 4 on, arrays of numbers, but for the last two.
constexpr std::uint32_t kCells = 1, kStructure = 2, kObject = 3, kSparse = 5, kFunction = 16, kOpaque = 17;

struct Element {
  std::uint32_t kind = 0;
  std::string_view content;
};

class SizeCheck {
 public:
  SizeCheck(bool lowest_first, const std::string& path, const std::string& expected)
      : lowest_first_(lowest_first), path_(path), expected_(expected) {}

  // What follows the header: variable after variable, without bytes between them.
  void variables(std::string_view rest) const {
    while (rest.size() >= 8) {
      const Element element = next(rest, 1);
      require(element.kind == kMatrix || element.kind == kCompressed, "no variable where one should be");
      if (element.kind == kMatrix) {
        array(element.content, 0);
      } else {
        compressed(element.content);
      }
    }
  }

 private:
  void require(bool holds, std::string_view found) const {
    check(holds, "{}: found damaged or truncated data ({}); expected {}", path_, found, expected_);
  }

  std::uint32_t number(std::string_view bytes) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value = value << 8 | static_cast<unsigned char>(bytes[lowest_first_ ? 3 - i : i]);
    return value;
  }

  // The element at the start of `rest`, which it takes off, with what fills it up to a multiple of `step` bytes.
  Element next(std::string_view& rest, std::size_t step = 8) const {
    require(rest.size() >= 8, "an element that is cut");
    const std::uint32_t kind = number(rest);
    const std::uint32_t packed = kind >> 16;  // the length of up to 4 bytes that stand where lengths do else
    if (packed != 0) {
      require(packed <= 4, "a length that cannot be");
      const Element element{kind & 0xFFFF, rest.substr(4, packed)};
      rest.remove_prefix(8);
      return element;
    }
    const std::size_t length = number(rest.substr(4));
    require(length <= rest.size() - 8, "a length that goes beyond the end");
    const Element element{kind, rest.substr(8, length)};
    rest.remove_prefix(std::min(rest.size(), 8 + (length + step - 1) / step * step));
    return element;
  }

  std::string_view next_of(std::uint32_t kind, std::string_view& rest) const {
    const Element element = next(rest);
    require(element.kind == kind, "another kind of element than should be there");
    return element.content;
  }

  void array(std::string_view rest, int depth) const {
    if (rest.empty()) return;  // so MATLAB writes empty cells
    require(depth <= kDepth, "too many cells within cells");
    const std::string_view flags = next_of(kUint32, rest);
    require(flags.size() == 8, "no class of an array");
    const std::uint32_t array_class = number(flags) & 0xFF;
    if (array_class == kOpaque) {
      // Its names stand where other arrays have their sides; libmatio reads no more.
      for (int i = 0; i < 3; ++i) next_of(kInt8, rest);
      return;
    }
    const double items = product_of_sides(next_of(kInt32, rest));
    next_of(kInt8, rest);  // name
    if (array_class == kCells) {
      arrays(items, rest, depth);
    } else if (array_class == kStructure || array_class == kObject) {
      if (array_class == kObject) next_of(kInt8, rest);  // name of its class
      arrays(items * static_cast<double>(fields(rest)), rest, depth);
    } else if (array_class == kFunction) {
      arrays(items, rest, depth);
    } else if (array_class != kSparse && items > 0.0) {
      const Element numbers = next(rest);
      require(items <= static_cast<double>(numbers.content.size()), "more numbers than bytes");
    }
  }

  // As double: the product of damaged sides may be more than an integer holds.
  double product_of_sides(std::string_view sides) const {
    require(sides.size() >= 8 && sides.size() % 4 == 0, "an array without two sides");
    double product = 1.0;
    for (; !sides.empty(); sides.remove_prefix(4)) product *= static_cast<double>(number(sides));
    return product;
  }

  // The number of fields, whose names it takes off.
  std::size_t fields(std::string_view& rest) const {
    const std::string_view length = next_of(kInt32, rest);
    require(length.size() == 4 && number(length) > 0, "no length of the names of fields");
    return next_of(kInt8, rest).size() / number(length);
  }

  void arrays(double count, std::string_view rest, int depth) const {
    require(count <= static_cast<double>(rest.size()) / 8.0, "more cells or fields than bytes");
    for (double i = 0.0; i < count; i += 1.0) {
      const std::string_view content = next_of(kMatrix, rest);
      require(content.size() % 8 == 0, "an array that ends between its elements");
      array(content, depth + 1);
    }
  }

  void compressed(std::string_view content) const {
    const std::string text = inflated(content);
    std::string_view rest = text;
    array(next_of(kMatrix, rest), 0);
  }

  std::string inflated(std::string_view content) const {
    z_stream stream{};
    check(inflateInit(&stream) == Z_OK, "{}: zlib cannot start", path_);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
    stream.avail_in = static_cast<uInt>(content.size());
    std::string text;
    std::array<char, 16384> part{};
    int state = Z_OK;
    while (state == Z_OK) {
      stream.next_out = reinterpret_cast<Bytef*>(part.data());
      stream.avail_out = part.size();
      state = inflate(&stream, Z_NO_FLUSH);
      text.append(part.data(), part.size() - stream.avail_out);
    }
    inflateEnd(&stream);
    require(state == Z_STREAM_END, "compressed data that cannot be those that were written");
    return text;
  }

  bool lowest_first_;
  const std::string& path_;
  const std::string& expected_;
};

}  // namespace

void check_matlab_sizes(std::string_view bytes, const std::string& path, const std::string& expected) {
  const std::string_view version = bytes.substr(std::min(bytes.size(), kHeader - 4), 4);
  const bool lowest_first = version == std::string_view("\x00\x01IM", 4);
  check(lowest_first || version == std::string_view("\x01\x00MI", 4),
        "{}: found no MATLAB 5 to 7.3 file (another version, or no MATLAB file at all); expected {}", path,
        expected);
  SizeCheck(lowest_first, path, expected).variables(bytes.substr(kHeader));
}

}  // namespace s2nnds
