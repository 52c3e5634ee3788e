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

class AxisReader {
 public:
  AxisReader(std::string source) : source_(std::move(source)) {}

  // A table that has none of an axis's words is the first part of a dotted key that was written without
  // quotes.
  void read_table(const toml::table& table, const std::string& prefix) {
    for (const auto& [key, node] : table) {
      const std::string name = prefix + std::string(key.str());
      const auto* inner = node.as_table();
      if (inner != nullptr && !inner->contains("values") && !inner->contains("range") &&
          !inner->contains("log_range")) {
        read_table(*inner, name + ".");
      } else {
        axes_.push_back({node.source().begin, read_axis(name, node)});
      }
    }
  }

  std::vector<Axis> in_order() {
    const auto before = [](const Found& a, const Found& b) {
      return std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
    };
    std::stable_sort(axes_.begin(), axes_.end(), before);
    std::vector<Axis> axes;
    for (Found& found : axes_) axes.push_back(std::move(found.axis));
    return axes;
  }

 private:
  struct Found {
    toml::source_position place;
    Axis axis;
  };

  std::string where(const toml::node& node, const std::string& name) const {
    return fmt::format("{}:{}: axes: {}", source_, node.source().begin.line, name);
  }

  Axis read_axis(const std::string& name, const toml::node& node) const {
    Axis axis;
    axis.key = name;
    axis.line = node.source().begin.line;
    const auto* table = node.as_table();
    if (table == nullptr) {
      read_values(axis, node);
    } else {
      read_fields(axis, *table);
    }
    return axis;
  }

  void read_fields(Axis& axis, const toml::table& table) const {
    check(table.contains("values") + table.contains("range") + table.contains("log_range") == 1,
          "{}: expected one of values, range and log_range", where(table, axis.key));
    for (const auto& [key, node] : table) {
      if (key == "values") {
        read_values(axis, node);
      } else if (key == "range" || key == "log_range") {
        axis.logarithmic = key == "log_range";
        read_range(axis, node);
      } else if (key == "count") {
        const auto count = node.value_exact<std::int64_t>();
        check(count && *count >= 1, "{}: count: expected an integer >= 1, found {}", where(node, axis.key),
              toml_text(node));
        axis.count = *count;
      } else if (key == "also") {
        read_also(axis, node);
      } else {
        fail("{}: unknown key {}; expected values, range, log_range, count or also", where(node, axis.key),
             key.str());
      }
    }
  }

  void read_values(Axis& axis, const toml::node& node) const {
    const auto* array = node.as_array();
    check(array != nullptr && !array->empty(), "{}: expected a list of at least one value, found {}",
          where(node, axis.key), toml_text(node));
    for (const toml::node& value : *array) {
      axis.values.push_back(toml_text(value));
      const auto repeated = std::count(axis.values.begin(), axis.values.end(), axis.values.back());
      check(repeated == 1, "{}: found {} twice; expected different values", where(value, axis.key),
            axis.values.back());
    }
  }

  void read_range(Axis& axis, const toml::node& node) const {
    const auto* array = node.as_array();
    const bool two =
        array != nullptr && array->size() == 2 && (*array)[0].is_number() && (*array)[1].is_number();
    check(two, "{}: expected a range of two numbers, found {}", where(node, axis.key), toml_text(node));
    axis.low = *(*array)[0].value<double>();
    axis.high = *(*array)[1].value<double>();
    axis.integer = (*array)[0].is_integer() && (*array)[1].is_integer();
    check(std::isfinite(axis.low) && std::isfinite(axis.high) && axis.low < axis.high,
          "{}: expected a range that rises, found {}", where(node, axis.key), toml_text(node));
    check(!axis.logarithmic || axis.low > 0.0, "{}: expected a logarithmic range of numbers > 0, found {}",
          where(node, axis.key), toml_text(node));
  }

  void read_also(Axis& axis, const toml::node& node) const {
    const auto* array = node.as_array();
    check(array != nullptr && array->is_homogeneous<std::string>(),
          "{}: also: expected a list of keys, found {}", where(node, axis.key), toml_text(node));
    for (const toml::node& key : *array) axis.also.push_back(*key.value<std::string>());
  }

  std::string source_;
  std::vector<Found> axes_;
};

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
  AxisReader reader(source);
  reader.read_table(*axes->as_table(), "");
  return reader.in_order();
}

}  // namespace s2nnds
