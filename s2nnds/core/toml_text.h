// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace s2nnds {

// A text as TOML, quoted. Like all functions here it gives one line that reads back to the same value.
std::string string_text(std::string_view text);
std::string key_text(std::string_view key);       // quoted where it must be
std::string toml_text(bool value);                // true, false
std::string toml_text(std::int64_t value);        // decimal
std::string toml_text(const std::string& value);  // quoted
// The shortest text that reads back to the same double; with a point or an exponent, since TOML tells
// integers apart.
std::string toml_text(double value);
std::string toml_text(const toml::node& node);  // of any kind; a table as an inline table

// The array "[a, b]".
template <typename T>
std::string toml_text(const std::vector<T>& values) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size(); ++i) out += (i > 0 ? ", " : "") + toml_text(values[i]);
  return out + "]";
}

}  // namespace s2nnds
