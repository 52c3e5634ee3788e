// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/toml_text.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

std::string table_text(const toml::table& table) {
  std::string out = "{";
  for (const auto& [key, value] : table) {
    out += fmt::format("{}{} = {}", out.size() > 1 ? ", " : "", key_text(key.str()), toml_text(value));
  }
  return out + "}";
}

// On one line, so that an array keeps the line of its key.
std::string array_text(const toml::array& array) {
  std::string out = "[";
  for (const toml::node& element : array) out += (out.size() > 1 ? ", " : "") + toml_text(element);
  return out + "]";
}

}  // namespace

std::string string_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    switch (c) {
      case '"':
        out += "\\\"";
        break;
      case '\\':
        out += "\\\\";
        break;
      case '\n':
        out += "\\n";
        break;
      case '\t':
        out += "\\t";
        break;
      case '\r':
        out += "\\r";
        break;
      default:
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
          out += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
        } else {
          out += c;
        }
    }
  }
  return out + '"';
}

std::string toml_text(bool value) { return value ? "true" : "false"; }
std::string toml_text(std::int64_t value) { return fmt::format("{}", value); }
std::string toml_text(const std::string& value) { return string_text(value); }

std::string toml_text(double value) {
  std::string text = fmt::format("{}", value);
  return text.find_first_of(".ein") == std::string::npos ? text + ".0" : text;
}

std::string key_text(std::string_view key) {
  const auto is_bare = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  return !key.empty() && std::all_of(key.begin(), key.end(), is_bare) ? std::string(key) : string_text(key);
}

std::string toml_text(const toml::node& node) {
  if (const auto* table = node.as_table()) return table_text(*table);
  if (const auto* array = node.as_array()) return array_text(*array);
  if (const auto* text = node.as_string()) return string_text(text->get());
  if (const auto* number = node.as_floating_point()) return toml_text(number->get());
  if (const auto* number = node.as_integer()) return toml_text(number->get());
  if (const auto* flag = node.as_boolean()) return toml_text(flag->get());
  std::ostringstream out;  // dates and times
  node.visit([&out](const auto& value) {
    if constexpr (toml::is_chronological<decltype(value)>) out << value.get();
  });
  return out.str();
}

}  // namespace s2nnds
