// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace s2nnds {

// The admissible range of a number, for validation and for messages.
struct Range {
  double low = -std::numeric_limits<double>::infinity();  // least value
  double high = std::numeric_limits<double>::infinity();  // greatest value
  bool open_low = false;                                  // the lower end is excluded
  bool open_high = false;                                 // the upper end is excluded

  bool holds(double value) const;  // false for NaN; infinite values only where there is no bound at all
  std::string describe() const;    // "a number > 0", "a number >= 1", "a number in [0, 1)", "a number" ...
};
inline Range at_least(double low) { return {.low = low}; }                 // value >= low
inline Range above(double low) { return {.low = low, .open_low = true}; }  // value > low
// low <= value <= high
inline Range between(double low, double high) { return {.low = low, .high = high}; }
// low < value < high
inline Range inside(double low, double high) {
  return {.low = low, .high = high, .open_low = true, .open_high = true};
}
inline Range any_number() { return {}; }  // infinite values allowed, NaN not

// The value of a field that takes one of a few words or a list of numbers: "mean", [0.5, 0.2].
struct WordOrNumbers {
  std::string word;                  // empty where the numbers count
  std::vector<double> numbers = {};  // count where there is no word

  bool operator==(const WordOrNumbers&) const = default;  // both alike
};

class StructList;

// Options are structs with a default beside every field and one member `void visit(FieldVisitor&)` that names
// each field once. Reading a configuration, writing it back, validating it and reporting it are visitors.
// `visit` may branch on fields that it has visited already (a region's keys depend on its type).
class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;

  // One field with its key and its value, which the visitor may read or set; here true or false.
  virtual void field(std::string_view name, bool& value) = 0;
  virtual void field(std::string_view name, std::int64_t& value, Range range) = 0;  // an integer in `range`
  virtual void field(std::string_view name, double& value, Range range) = 0;        // a number in `range`
  // One of `choices`; any text if there are none.
  virtual void field(std::string_view name, std::string& value, const std::vector<std::string>& choices) = 0;
  void field(std::string_view name, std::string& value) { field(name, value, {}); }  // any text
  // Numbers, each in `range`.
  virtual void field(std::string_view name, std::vector<double>& value, Range range) = 0;
  // Integers, each in `range`.
  virtual void field(std::string_view name, std::vector<std::int64_t>& value, Range range) = 0;
  virtual void field(std::string_view name, std::vector<std::string>& value) = 0;  // any texts
  // Lists of numbers, such as points, each number in `range`.
  virtual void field(std::string_view name, std::vector<std::vector<double>>& value, Range range) = 0;
  // One of `words`, or numbers.
  virtual void field(std::string_view name, WordOrNumbers& value, const std::vector<std::string>& words) = 0;

  // Options within options: their fields have keys "name.key".
  template <typename T>
  void group(std::string_view name, T& options) {
    begin_group(name);
    options.visit(*this);
    end_group();
  }
  // A list of options structs, whose length the visitor may change.
  template <typename T>
  void list(std::string_view name, std::vector<T>& elements);

 protected:
  virtual void begin_group(std::string_view name) = 0;  // before the fields of a group
  virtual void end_group() = 0;                         // after them
  // What list() calls.
  virtual void visit_list(std::string_view name, StructList& list) = 0;
};

// A list of options structs, as a visitor sees it.
class StructList {
 public:
  virtual ~StructList() = default;
  virtual std::size_t size() const = 0;        // structs in the list
  virtual void resize(std::size_t count) = 0;  // new structs have their defaults
  // Visits the fields of one struct; index < size().
  virtual void visit(std::size_t index, FieldVisitor& visitor) = 0;
};

template <typename T>
void FieldVisitor::list(std::string_view name, std::vector<T>& elements) {
  struct List : StructList {
    explicit List(std::vector<T>& all) : elements(all) {}
    std::size_t size() const override { return elements.size(); }
    void resize(std::size_t count) override { elements.resize(count); }
    void visit(std::size_t index, FieldVisitor& visitor) override { elements[index].visit(visitor); }
    std::vector<T>& elements;
  } list(elements);
  visit_list(name, list);
}

// The bound of a field that has neither a range nor choices.
struct NoBound {};

// For visitors that treat all types of fields alike: `Derived` has a member template each(name, value,
// bound), where `bound` is a Range, the choices (a list of strings) or NoBound.
template <typename Derived, typename Base = FieldVisitor>
class UniformVisitor : public Base {
 public:
  using Base::Base;
  using Base::field;
  // All of them call each(): without a bound.
  void field(std::string_view name, bool& value) override { self().each(name, value, NoBound{}); }
  // With the range.
  void field(std::string_view name, std::int64_t& value, Range range) override {
    self().each(name, value, range);
  }
  // With the range.
  void field(std::string_view name, double& value, Range range) override { self().each(name, value, range); }
  // With the choices, none if any text will do.
  void field(std::string_view name, std::string& value, const std::vector<std::string>& choices) override {
    self().each(name, value, choices);
  }
  // With the range of every element.
  void field(std::string_view name, std::vector<double>& value, Range range) override {
    self().each(name, value, range);
  }
  // With the range of every element.
  void field(std::string_view name, std::vector<std::int64_t>& value, Range range) override {
    self().each(name, value, range);
  }
  // Without a bound.
  void field(std::string_view name, std::vector<std::string>& value) override {
    self().each(name, value, NoBound{});
  }
  // With the range of every number.
  void field(std::string_view name, std::vector<std::vector<double>>& value, Range range) override {
    self().each(name, value, range);
  }
  // With the words.
  void field(std::string_view name, WordOrNumbers& value, const std::vector<std::string>& words) override {
    self().each(name, value, words);
  }

 private:
  Derived& self() { return static_cast<Derived&>(*this); }
};

namespace options_detail {
using Visit = std::function<void(FieldVisitor&)>;
void read_toml(const std::string& text, const std::string& source, const std::vector<std::string>& settings,
               const Visit& visit);
std::string to_toml(const Visit& visit);
std::string to_json(const Visit& visit);
void validate(const Visit& visit);
std::vector<std::pair<std::string, std::string>> flatten(const Visit& visit);
}  // namespace options_detail

// Sets the fields that the TOML `text` and then the `settings` (see settings.h) name; throws Error with
// `source`, line (or "setting"), key, what was found and what was expected when a key is unknown (the nearest
// known one is suggested), has the wrong type or is out of range. `options` stay as they were when it throws.
// A list of structs is an array of tables, which replaces the old list.
template <typename T>
void read_toml(const std::string& text, const std::string& source, T& options,
               const std::vector<std::string>& settings = {}) {
  T read = options;
  options_detail::read_toml(text, source, settings, [&](FieldVisitor& v) { read.visit(v); });
  options = std::move(read);
}

// Every field with its value, as TOML that read_toml takes back to the same options. Throws Error for NaN.
template <typename T>
std::string to_toml(T options) {
  return options_detail::to_toml([&](FieldVisitor& v) { options.visit(v); });
}

// Every field with its value, as one JSON object with the fields in order; null for numbers that are not
// finite.
template <typename T>
std::string to_json(T options) {
  return options_detail::to_json([&](FieldVisitor& v) { options.visit(v); });
}

// Throws Error naming field, value and bound for the first field out of its range. For options set in code.
template <typename T>
void validate(T options) {
  options_detail::validate([&](FieldVisitor& v) { options.visit(v); });
}

// (dotted key, value as text) of every field, in order; elements of a list of structs count from 0:
// "of.0.radius".
template <typename T>
std::vector<std::pair<std::string, std::string>> flatten(T options) {
  return options_detail::flatten([&](FieldVisitor& v) { options.visit(v); });
}

}  // namespace s2nnds
