// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace s2nnds {

// Text from a file as a message can show it, on one line: '?' for each control character.
inline std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text;
}

}  // namespace s2nnds
