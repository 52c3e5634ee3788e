// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/settings.h"

#include <algorithm>
#include <sstream>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"
#include "s2nnds/core/toml_text.h"

namespace s2nnds {
namespace {

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// A table that holds the value of the setting under the key "value".
toml::table parse_value(const std::string& text, const std::string& setting) {
  try {
    toml::table table = toml::parse("value = " + text);
    if (table.size() == 1) return table;
  } catch (const toml::parse_error&) {  // not TOML, so a string that was given without quotes
  }
  try {
    return toml::parse("value = " + string_text(text));
  } catch (const toml::parse_error&) {  // it could not be written down
    fail("setting \"{}\": expected text in UTF-8", printable(setting, 200));
  }
}

// The element of `parent` of that name; a table is made where a table lacks it. Null: there can be none.
toml::node* child(toml::node& parent, const std::string& name) {
  if (auto* table = parent.as_table()) {
    if (!table->contains(name)) table->insert(name, toml::table{});
    return table->get(name);
  }
  auto* array = parent.as_array();
  const bool is_index =
      !name.empty() && name.size() < 10 &&
      std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c); });
  return array != nullptr && is_index ? array->get(std::stoul(name)) : nullptr;
}

}  // namespace

toml::table parse_toml(const std::string& text, const std::string& source) {
  try {
    return toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    fail("{}:{}: not TOML: {}", source, error.source().begin.line,
         printable(std::string(error.description()), 400));
  }
}

void apply_setting(toml::table& document, const std::string& setting) {
  const auto equals = setting.find('=');
  check(equals != std::string::npos, "setting \"{}\": expected key=value", printable(setting, 200));
  std::vector<std::string> path;
  std::istringstream keys(trimmed(setting.substr(0, equals)) + ".");
  for (std::string key; std::getline(keys, key, '.');) {
    check(!key.empty(), "setting \"{}\": expected a dotted key before \"=\"", printable(setting, 200));
    path.push_back(key);
  }
  const std::string name = path.back();
  path.pop_back();
  toml::node* parent = &document;
  for (const std::string& key : path) {
    parent = child(*parent, key);
    check(parent != nullptr, "setting \"{}\": there is no {} to set it in", printable(setting, 200),
          printable(key, 200));
  }
  const toml::table holder = parse_value(trimmed(setting.substr(equals + 1)), setting);
  const toml::node& value = *holder.get("value");
  if (auto* table = parent->as_table()) {
    value.visit([&](const auto& node) { table->insert_or_assign(name, node); });
    return;
  }
  check(child(*parent, name) != nullptr, "setting \"{}\": there is no {} to set", printable(setting, 200),
        printable(name, 200));
  auto* array = parent->as_array();
  value.visit([&](const auto& node) { array->replace(array->cbegin() + std::stol(name), node); });
}

std::string with_settings(const std::string& text, const std::string& source,
                          const std::vector<std::string>& settings) {
  toml::table document = parse_toml(text, source);
  if (settings.empty()) return text;
  for (const std::string& setting : settings) apply_setting(document, setting);
  // Of texts with line breaks or quotes toml++'s other two notations do not read back to the same.
  const auto flags = toml::toml_formatter::default_flags & ~(toml::format_flags::allow_literal_strings |
                                                             toml::format_flags::allow_multi_line_strings);
  std::ostringstream out;
  out << toml::toml_formatter(document, flags) << '\n';
  return out.str();
}

}  // namespace s2nnds
