// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace s2nnds {

// Values as TOML text that reads back to the same value, on one line.
std::string string_text(std::string_view text);  // quoted
std::string key_text(std::string_view key);      // quoted where it must be
std::string toml_text(bool value);
std::string toml_text(std::int64_t value);
std::string toml_text(const std::string& value);
// The shortest text that reads back to the same double; with a point or an exponent, since TOML tells
// integers apart.
std::string toml_text(double value);
std::string toml_text(const toml::node& node);

template <typename T>
std::string toml_text(const std::vector<T>& values) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size(); ++i) out += (i > 0 ? ", " : "") + toml_text(values[i]);
  return out + "]";
}

}  // namespace s2nnds
