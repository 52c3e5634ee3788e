// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/options.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "s2nnds/core/check.h"
#include "s2nnds/core/json_text.h"
#include "s2nnds/core/printable.h"
#include "s2nnds/core/settings.h"
#include "s2nnds/core/toml_text.h"

namespace s2nnds {

bool Range::holds(double value) const {
  const double infinity = std::numeric_limits<double>::infinity();
  if (std::isinf(value)) return low == -infinity && high == infinity;
  return (open_low ? value > low : value >= low) && (open_high ? value < high : value <= high);
}

std::string Range::describe() const {
  const bool has_low = std::isfinite(low);
  const bool has_high = std::isfinite(high);
  if (has_low && has_high) {
    return fmt::format("a number in {}{}, {}{}", open_low ? '(' : '[', low, high, open_high ? ')' : ']');
  }
  if (has_low) return fmt::format("a number {} {}", open_low ? ">" : ">=", low);
  if (has_high) return fmt::format("a number {} {}", open_high ? "<" : "<=", high);
  return "a number";
}

namespace {

// Words of the file, for messages, which name one or two of them.
std::string excerpt(std::string text) { return printable(std::move(text), 200); }

// What stands in the file, for messages: `an integer 3`, `a string "abc"`.
std::string found(const toml::node& node) {
  if (node.is_table()) return "a table";
  if (node.is_array()) return fmt::format("a list of {}", node.as_array()->size());
  if (node.is_string()) return "a string " + excerpt(toml_text(node));
  if (node.is_floating_point()) return "a number " + toml_text(node);
  if (node.is_integer()) return "an integer " + toml_text(node);
  if (node.is_boolean()) return "a truth value " + toml_text(node);
  return "a date or time " + toml_text(node);
}

// ---- Misspelt names

// Levenshtein distance, with a swap of two neighbours counted as one edit.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] =
          std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

// The candidate nearest to `name`, if it is near enough to be what was meant.
template <typename Names>
std::optional<std::string> nearest(std::string_view name, const Names& candidates) {
  std::optional<std::string> best;
  std::size_t best_distance = 1 + name.size() / 3;
  for (const std::string& candidate : candidates) {
    // Each letter that one has more is an edit.
    if (std::max(name.size(), candidate.size()) - std::min(name.size(), candidate.size()) > best_distance)
      continue;
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < best_distance || (distance == best_distance && !best)) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

template <typename Names>
std::string joined(const Names& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

// ---- Visitors

// Keeps the dotted name of the group that is being visited.
class NamedVisitor : public FieldVisitor {
 protected:
  std::string name_of(std::string_view name) const { return prefix() + std::string(name); }
  std::string prefix() const { return groups_.empty() ? "" : groups_.back(); }

  void begin_group(std::string_view name) override { groups_.push_back(name_of(name) + "."); }
  void end_group() override { groups_.pop_back(); }
  void visit_list(std::string_view name, StructList& list) override {
    for (std::size_t i = 0; i < list.size(); ++i) {
      begin_group(fmt::format("{}.{}", name, i));
      list.visit(i, *this);
      end_group();
    }
  }

 private:
  std::vector<std::string> groups_;
};

// `where` is "file:line: " or empty.
void check_bound(const std::string&, const std::string&, const auto&, const NoBound&) {}
void check_bound(const std::string& where, const std::string& name, const auto& value, const Range& range) {
  check(range.holds(static_cast<double>(value)), "{}{}: expected {}, found {}", where, name, range.describe(),
        value);
}
void check_bound(const std::string& where, const std::string& name, const std::string& value,
                 const std::vector<std::string>& choices) {
  if (choices.empty() || std::find(choices.begin(), choices.end(), value) != choices.end()) return;
  const auto guess = nearest(value, choices);
  fail("{}{}: expected one of {}, found {}{}", where, name, joined(choices), excerpt(string_text(value)),
       guess ? fmt::format("; did you mean {}?", *guess) : "");
}
void check_bound(const std::string& where, const std::string& name, const WordOrNumbers& value,
                 const std::vector<std::string>& words) {
  if (!value.word.empty()) return check_bound(where, name, value.word, words);
  check(!value.numbers.empty(), "{}{}: expected one of {}, or a list of numbers, found an empty list", where,
        name, joined(words));
  for (const double number : value.numbers) check_bound(where, name, number, any_number());
}

// Of a list, each element; where(i) says where it stands, where(0) as well where a single value stands.
template <typename T, typename Bound, typename Where>
void check_value(const std::string& name, const T& value, const Bound& bound, const Where& where) {
  check_bound(where(0), name, value, bound);
}
template <typename T, typename Bound, typename Where>
void check_value(const std::string& name, const std::vector<T>& values, const Bound& bound,
                 const Where& where) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    check_value(fmt::format("{}[{}]", name, i), values[i], bound, [&](std::size_t) { return where(i); });
  }
}

class Validator final : public UniformVisitor<Validator, NamedVisitor> {
 public:
  template <typename T, typename Bound>
  void each(std::string_view name, const T& value, const Bound& bound) const {
    check_value(name_of(name), value, bound, [](std::size_t) { return ""; });
  }
};

template <typename T>
constexpr std::string_view expected_type = "";
template <>
constexpr std::string_view expected_type<bool> = "true or false";
template <>
constexpr std::string_view expected_type<std::int64_t> = "an integer";
template <>
constexpr std::string_view expected_type<double> = "a number";
template <>
constexpr std::string_view expected_type<std::string> = "a string";
template <>
constexpr std::string_view expected_type<WordOrNumbers> = "a string or a list of numbers";
template <>
constexpr std::string_view expected_type<std::vector<double>> = "a list of numbers";
template <>
constexpr std::string_view expected_type<std::vector<std::int64_t>> = "a list of integers";
template <>
constexpr std::string_view expected_type<std::vector<std::string>> = "a list of strings";
template <>
constexpr std::string_view expected_type<std::vector<std::vector<double>>> =
    "a list of lists of numbers such as [[0, 0], [1, 0]]";

class TomlReader final : public UniformVisitor<TomlReader, NamedVisitor> {
 public:
  TomlReader(const toml::table& root, std::string source) : root_(root), source_(std::move(source)) {
    tables_.push_back(&root_);
  }

  // To be called after the visit, which is what tells the known keys.
  void check_for_unknown_keys() const { check_table(root_, ""); }

  template <typename T, typename Bound>
  void each(std::string_view name, T& value, const Bound& bound) {
    const toml::node* node = read(name, value);
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    check_value(name_of(name), value, bound, [&](std::size_t i) {
      return where(array != nullptr && i < array->size() ? (*array)[i] : *node);
    });
  }

 protected:
  void begin_group(std::string_view name) override {
    const toml::node* node = find(name);
    enter(name, node);
  }
  void end_group() override {
    tables_.pop_back();
    NamedVisitor::end_group();
  }
  void visit_list(std::string_view name, StructList& list) override {
    const toml::node* node = find(name);
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    check(array != nullptr, "{}{}: expected a list of tables, found {}", where(*node), name_of(name),
          found(*node));
    list.resize(0);
    list.resize(array->size());
    for (std::size_t i = 0; i < array->size(); ++i) {
      enter(fmt::format("{}.{}", name, i), array->get(i));
      list.visit(i, *this);
      end_group();
    }
  }

 private:
  std::string where(const toml::node& node) const { return where(node.source()); }
  std::string where(const toml::source_region& region) const {
    if (!region.path) return fmt::format("{}, setting: ", source_);  // on no line of the file
    return fmt::format("{}:{}: ", source_, region.begin.line);
  }

  // The node of that name in the table being read, or null; from now on the name is known.
  const toml::node* find(std::string_view name) {
    known_[prefix()].push_back(std::string(name));
    return tables_.back() == nullptr ? nullptr : tables_.back()->get(name);
  }

  // A table that the file does not have is visited all the same: its fields are known and keep their
  // defaults.
  void enter(std::string_view name, const toml::node* node) {
    check(node == nullptr || node->is_table(), "{}{}: expected a table, found {}",
          node != nullptr ? where(*node) : "", name_of(name), node != nullptr ? found(*node) : "");
    tables_.push_back(node == nullptr ? nullptr : node->as_table());
    NamedVisitor::begin_group(name);
    known_[prefix()];
  }

  static bool convert(const toml::node& node, bool& value) { return assign(node.as_boolean(), value); }
  static bool convert(const toml::node& node, std::int64_t& value) {
    return assign(node.as_integer(), value);
  }
  static bool convert(const toml::node& node, std::string& value) { return assign(node.as_string(), value); }
  static bool convert(const toml::node& node, double& value) {
    return assign(node.as_floating_point(), value) || assign(node.as_integer(), value);
  }
  static bool convert(const toml::node& node, std::vector<double>& values) {
    const toml::array* array = node.as_array();
    values.assign(array != nullptr ? array->size() : 0, 0.0);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!convert((*array)[i], values[i])) return false;
    }
    return array != nullptr;
  }
  template <typename Node, typename T>
  static bool assign(const Node* node, T& value) {
    if (node != nullptr) value = static_cast<T>(node->get());
    return node != nullptr;
  }

  template <typename T>
  const toml::node* read(std::string_view name, T& value) {
    const toml::node* node = find(name);
    if (node != nullptr) {
      check(convert(*node, value), "{}{}: expected {}, found {}", where(*node), name_of(name),
            expected_type<T>, found(*node));
    }
    return node;
  }

  template <typename T>
  const toml::node* read(std::string_view name, std::vector<T>& values) {
    const toml::node* node = find(name);
    if (node == nullptr) return nullptr;
    const toml::array* array = node->as_array();
    check(array != nullptr, "{}{}: expected {}, found {}", where(*node), name_of(name),
          expected_type<std::vector<T>>, found(*node));
    read_elements(name, *array, values);
    return node;
  }

  const toml::node* read(std::string_view name, WordOrNumbers& value) {
    const toml::node* node = find(name);
    if (node == nullptr) return nullptr;
    value = {};
    if (const toml::array* array = node->as_array()) {
      read_elements(name, *array, value.numbers);
    } else {
      check(convert(*node, value.word), "{}{}: expected {}, found {}", where(*node), name_of(name),
            expected_type<WordOrNumbers>, found(*node));
    }
    return node;
  }

  template <typename T>
  void read_elements(std::string_view name, const toml::array& array, std::vector<T>& values) {
    values.assign(array.size(), T{});
    for (std::size_t i = 0; i < values.size(); ++i) {
      const toml::node& element = array[i];
      check(convert(element, values[i]), "{}{}[{}]: expected {}, found {}", where(element), name_of(name), i,
            expected_type<T>, found(element));
    }
  }

  void check_table(const toml::table& table, const std::string& prefix) const {
    const std::vector<std::string>& names = known_.at(prefix);
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        fail("{}unknown key {}{}; {}", where(key.source()), prefix, excerpt(name), suggestion(prefix, name));
      }
      check_inside(node, prefix + name);
    }
  }

  void check_inside(const toml::node& node, const std::string& name) const {
    if (const auto* table = node.as_table()) check_table(*table, name + ".");
    const auto* array = node.as_array();
    for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
      if (const auto* table = (*array)[i].as_table()) check_table(*table, fmt::format("{}.{}.", name, i));
    }
  }

  std::string suggestion(const std::string& prefix, const std::string& name) const {
    const std::vector<std::string>& here = known_.at(prefix);
    if (const auto guess = nearest(name, here)) return fmt::format("did you mean {}{}?", prefix, *guess);
    if (prefix.empty()) {  // perhaps its table was forgotten
      for (const auto& [table, names] : known_) {
        if (std::find(names.begin(), names.end(), name) != names.end()) {
          return fmt::format("did you mean {}{}?", table, name);
        }
      }
    }
    return here.empty() ? "expected none here" : "expected one of " + joined(here);
  }

  const toml::table& root_;
  std::string source_;
  std::vector<const toml::table*> tables_;  // those being visited; null where the file has none
  std::map<std::string, std::vector<std::string>> known_;  // names of fields and groups, by dotted prefix
};

std::string text_of(const auto& value) { return toml_text(value); }
std::string text_of(const WordOrNumbers& value) {
  return value.word.empty() ? toml_text(value.numbers) : toml_text(value.word);
}

// Visits every field as a pair of a name and a value's text.
class TextVisitor : public UniformVisitor<TextVisitor, NamedVisitor> {
 public:
  template <typename T, typename Bound>
  void each(std::string_view name, const T& value, const Bound&) {
    put(name, text_of(value));
  }

 protected:
  virtual void put(std::string_view name, std::string value) = 0;
};

class TomlTextVisitor : public TextVisitor {
 public:
  using TextVisitor::field;
  void field(std::string_view name, double& value, Range range) override {
    check_number(name, value);
    TextVisitor::field(name, value, range);
  }
  void field(std::string_view name, std::vector<double>& value, Range range) override {
    for (const double number : value) check_number(name, number);
    TextVisitor::field(name, value, range);
  }
  void field(std::string_view name, std::vector<std::vector<double>>& value, Range range) override {
    for (const std::vector<double>& row : value) {
      for (const double number : row) check_number(name, number);
    }
    TextVisitor::field(name, value, range);
  }
  void field(std::string_view name, WordOrNumbers& value, const std::vector<std::string>& words) override {
    for (const double number : value.numbers) check_number(name, number);
    TextVisitor::field(name, value, words);
  }

 private:
  void check_number(std::string_view name, double value) const {
    check(!std::isnan(value), "{}: expected a number to write, found nan", name_of(name));
  }
};

// One struct of a list: {a = 1, b = {c = 2}}.
class InlineTomlWriter final : public TomlTextVisitor {
 public:
  std::string text() const { return "{" + text_ + "}"; }

 protected:
  void put(std::string_view name, std::string value) override {
    if (!text_.empty() && text_.back() != '{') text_ += ", ";
    text_ += fmt::format("{} = {}", name, value);
  }
  void begin_group(std::string_view name) override {
    put(name, "{");
    TomlTextVisitor::begin_group(name);
  }
  void end_group() override {
    text_ += "}";
    TomlTextVisitor::end_group();
  }
  void visit_list(std::string_view name, StructList& list) override;

 private:
  std::string text_;
};

// The elements of a list of structs, one a line where that is allowed (not within an inline table).
std::string list_text(StructList& list, bool lines) {
  std::string out = "[";
  for (std::size_t i = 0; i < list.size(); ++i) {
    InlineTomlWriter element;
    list.visit(i, element);
    out += (i > 0 ? "," : "") + std::string(lines ? "\n  " : i > 0 ? " " : "") + element.text();
  }
  return out + (lines && list.size() > 0 ? "\n]" : "]");
}

void InlineTomlWriter::visit_list(std::string_view name, StructList& list) {
  put(name, list_text(list, false));
}

// A table's own keys must stand before its sub-tables, whatever the order of the visit: so one section a
// table.
class TomlWriter final : public TomlTextVisitor {
 public:
  TomlWriter() { begin_section(""); }
  std::string text() const {
    std::string out;
    for (const Section& section : sections_) {
      if (section.keys.empty()) continue;
      if (!section.table.empty()) out += fmt::format("{}[{}]\n", out.empty() ? "" : "\n", section.table);
      out += section.keys;
    }
    return out;
  }

 protected:
  void put(std::string_view name, std::string value) override {
    sections_[open_.back()].keys += fmt::format("{} = {}\n", name, value);
  }
  void begin_group(std::string_view name) override {
    begin_section(name_of(name));
    TomlTextVisitor::begin_group(name);
  }
  void end_group() override {
    open_.pop_back();
    TomlTextVisitor::end_group();
  }
  void visit_list(std::string_view name, StructList& list) override { put(name, list_text(list, true)); }

 private:
  struct Section {
    std::string table;
    std::string keys;
  };
  void begin_section(const std::string& table) {
    open_.push_back(sections_.size());
    sections_.push_back({table, ""});
  }
  std::vector<Section> sections_;
  std::vector<std::size_t> open_;
};

class Flattener final : public TextVisitor {
 public:
  using TextVisitor::field;
  void field(std::string_view name, std::string& value, const std::vector<std::string>&) override {
    put(name, value);  // without quotes
  }
  void field(std::string_view name, WordOrNumbers& value, const std::vector<std::string>&) override {
    put(name, value.word.empty() ? text_of(value) : value.word);
  }
  std::vector<std::pair<std::string, std::string>> entries;

 protected:
  void put(std::string_view name, std::string value) override {
    entries.emplace_back(name_of(name), std::move(value));
  }
  void visit_list(std::string_view name, StructList& list) override {
    if (list.size() == 0) put(name, "[]");
    TextVisitor::visit_list(name, list);
  }
};

class JsonWriter final : public UniformVisitor<JsonWriter> {
 public:
  JsonWriter() { open_.push_back(&root); }
  nlohmann::ordered_json root = nlohmann::ordered_json::object();

  template <typename T, typename Bound>
  void each(std::string_view name, const T& value, const Bound&) {
    if constexpr (std::is_same_v<T, WordOrNumbers>) {
      if (value.word.empty()) return each(name, value.numbers, NoBound{});
      return each(name, value.word, NoBound{});
    } else {
      at(name) = value;  // numbers that are not finite are dumped as null
    }
  }

 protected:
  void begin_group(std::string_view name) override {
    at(name) = nlohmann::ordered_json::object();
    open_.push_back(&at(name));
  }
  void end_group() override { open_.pop_back(); }
  void visit_list(std::string_view name, StructList& list) override {
    auto elements = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < list.size(); ++i) {
      JsonWriter element;
      list.visit(i, element);
      elements.push_back(std::move(element.root));
    }
    at(name) = std::move(elements);
  }

 private:
  nlohmann::ordered_json& at(std::string_view name) { return (*open_.back())[std::string(name)]; }
  std::vector<nlohmann::ordered_json*> open_;
};

}  // namespace

void options_detail::read_toml(const std::string& text, const std::string& source,
                               const std::vector<std::string>& settings, const Visit& visit) {
  toml::table root = parse_toml(text, source);
  for (const std::string& setting : settings) apply_setting(root, setting);
  TomlReader reader(root, source);
  visit(reader);
  reader.check_for_unknown_keys();
}

std::string options_detail::to_toml(const Visit& visit) {
  TomlWriter writer;
  visit(writer);
  return writer.text();
}

std::string options_detail::to_json(const Visit& visit) {
  JsonWriter writer;
  visit(writer);
  return json_text(writer.root);
}

void options_detail::validate(const Visit& visit) {
  Validator validator;
  visit(validator);
}

std::vector<std::pair<std::string, std::string>> options_detail::flatten(const Visit& visit) {
  Flattener flattener;
  visit(flattener);
  return std::move(flattener.entries);
}

}  // namespace s2nnds
