// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

namespace s2nnds {

// Text from a file as a message can show it, on one line: '?' for each control character, and "..." for what is left
// out after the first `length` bytes.
inline std::string printable(std::string text, std::size_t length = 1000) {
  if (text.size() > length) {
    while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80)
      --length;  // within a character
    text.replace(length, std::string::npos, "...");
  }
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text;
}

}  // namespace s2nnds
