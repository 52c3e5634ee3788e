// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/file_digest.h"

#include <string_view>

#include "s2nnds/core/check.h"
#include "s2nnds/core/sha256.h"

namespace s2nnds {
namespace {

constexpr std::string_view kMark = "\ns2nnds-sha256 ";
constexpr std::size_t kLength = kMark.size() + 64 + 1;  // of the line, in bytes

std::string line_of(std::string_view bytes) { return std::string(kMark) + sha256(bytes) + "\n"; }

}  // namespace

std::string with_digest(std::string bytes) {
  bytes += line_of(bytes);
  return bytes;
}

std::string without_digest(std::string bytes, const std::string& path) {
  const std::size_t from = bytes.size() > kLength ? bytes.size() - kLength : 0;
  const std::size_t at = bytes.find(kMark, from);
  if (at == std::string::npos) return bytes;
  check(
      bytes.compare(at, std::string::npos, line_of(std::string_view(bytes).substr(0, at))) == 0,
      "{}: expected a whole file, found {} bytes that are damaged: their SHA-256 is not the one at their end",
      path, bytes.size());
  bytes.resize(at);
  return bytes;
}

}  // namespace s2nnds
