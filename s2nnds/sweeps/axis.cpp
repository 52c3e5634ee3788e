// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/axis.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/toml_text.h"

namespace s2nnds {
namespace {

// Rounded to so many digits, which is what is run: nobody wants to type 0.017287352256509816 again.
std::string number_text(double value, bool integer, int digits) {
  if (integer) return toml_text(static_cast<std::int64_t>(std::llround(value)));
  return toml_text(std::stod(fmt::format("{:.{}g}", value, digits)));
}
constexpr int drawn_digits = 6;
constexpr int grid_digits = 12;

// What is read below throws Error with `where`: source, line and axis.

void read_values(const toml::node& node, const std::string& where, Axis& axis) {
  const auto* array = node.as_array();
  check(array != nullptr && !array->empty(), "{}: expected a list of at least one value, found {}", where,
        toml_text(node));
  for (const toml::node& value : *array) {
    const std::string text = toml_text(value);
    check(std::find(axis.values.begin(), axis.values.end(), text) == axis.values.end(),
          "{}: found {} twice; expected different values", where, text);
    axis.values.push_back(text);
  }
}

void read_range(const toml::node& node, const std::string& where, Axis& axis) {
  const auto* array = node.as_array();
  const bool two =
      array != nullptr && array->size() == 2 && (*array)[0].is_number() && (*array)[1].is_number();
  check(two, "{}: expected a range of two numbers, found {}", where, toml_text(node));
  axis.low = *(*array)[0].value<double>();
  axis.high = *(*array)[1].value<double>();
  axis.integer = (*array)[0].is_integer() && (*array)[1].is_integer();
  check(std::isfinite(axis.low) && std::isfinite(axis.high) && axis.low < axis.high,
        "{}: expected a range that rises, found {}", where, toml_text(node));
  check(!axis.logarithmic || axis.low > 0.0, "{}: expected a logarithmic range of numbers > 0, found {}",
        where, toml_text(node));
}

void read_field(const std::string& key, const toml::node& node, const std::string& where, Axis& axis) {
  if (key == "values") {
    read_values(node, where, axis);
  } else if (key == "range" || key == "log_range") {
    axis.logarithmic = key == "log_range";
    read_range(node, where, axis);
  } else if (key == "count") {
    axis.count = node.value_exact<std::int64_t>().value_or(0);
    check(axis.count >= 1, "{}: count: expected an integer >= 1, found {}", where, toml_text(node));
  } else if (key == "also") {
    const auto* array = node.as_array();
    check(array != nullptr && array->is_homogeneous<std::string>(),
          "{}: also: expected a list of keys, found {}", where, toml_text(node));
    for (const toml::node& other : *array) axis.also.push_back(*other.value<std::string>());
  } else {
    fail("{}: unknown key {}; expected values, range, log_range, count or also", where, key);
  }
}

int value_fields(const toml::table& table) {
  return table.contains("values") + table.contains("range") + table.contains("log_range");
}

// A table that has none of an axis's words is the first part of a dotted key that was written without quotes.
void read_table(const toml::table& table, const std::string& prefix, const std::string& source,
                std::vector<std::pair<toml::source_position, Axis>>& axes) {
  for (const auto& [key, node] : table) {
    const std::string name = prefix + std::string(key.str());
    const auto* inner = node.as_table();
    if (inner != nullptr && value_fields(*inner) == 0) {
      read_table(*inner, name + ".", source, axes);
      continue;
    }
    const auto where = [&](const toml::node& at) {
      return fmt::format("{}:{}: axes: {}", source, at.source().begin.line, name);
    };
    Axis axis{.key = name, .line = node.source().begin.line};
    if (inner == nullptr) {
      read_values(node, where(node), axis);
    } else {
      check(value_fields(*inner) == 1, "{}: expected one of values, range and log_range", where(node));
      for (const auto& [word, field] : *inner) read_field(std::string(word.str()), field, where(field), axis);
    }
    axes.emplace_back(node.source().begin, axis);
  }
}

}  // namespace

std::string Axis::at(double u) const {
  if (!values.empty()) {
    const auto index = static_cast<std::size_t>(u * static_cast<double>(values.size()));
    return values[std::min(index, values.size() - 1)];
  }
  if (logarithmic) return number_text(low * std::pow(high / low, u), integer, drawn_digits);
  if (integer)
    return number_text(std::min(high, low + std::floor(u * (high - low + 1.0))), true, drawn_digits);
  return number_text(low + u * (high - low), false, drawn_digits);
}

std::vector<std::string> Axis::grid() const {
  if (!values.empty()) return values;
  check(count >= 1, "axes: {}: expected a count, the grid's number of values from {} to {}", key, low, high);
  std::vector<std::string> points;
  for (std::int64_t i = 0; i < count; ++i) {
    const double u = count == 1 ? 0.5 : static_cast<double>(i) / static_cast<double>(count - 1);
    double value = logarithmic ? low * std::pow(high / low, u) : low + u * (high - low);
    if (i == 0 && count > 1) value = low;  // exactly
    if (i == count - 1 && count > 1) value = high;
    const std::string text = number_text(value, integer, grid_digits);
    if (points.empty() || points.back() != text) points.push_back(text);
  }
  return points;
}

std::vector<std::string> Axis::extremes() const {
  if (!values.empty()) return values;
  return {number_text(low, integer, grid_digits), number_text(high, integer, grid_digits)};
}

std::vector<Axis> read_axes(const std::string& text, const std::string& source) {
  toml::table root;
  try {
    root = toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    fail("{}:{}: not TOML: {}", source, error.source().begin.line, error.description());
  }
  const toml::node* axes = root.get("axes");
  if (axes == nullptr) return {};
  check(axes->is_table(), "{}:{}: axes: expected a table of keys", source, axes->source().begin.line);
  std::vector<std::pair<toml::source_position, Axis>> found;
  read_table(*axes->as_table(), "", source, found);
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first.line, a.first.column) < std::pair(b.first.line, b.first.column);
  });
  std::vector<Axis> in_order;
  for (auto& [place, axis] : found) in_order.push_back(std::move(axis));
  return in_order;
}

}  // namespace s2nnds
