// SPDX-License-Identifier: BSD-3-Clause
#include "keys_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "s2nnds/core/json_text.h"
#include "s2nnds/runs/config.h"

namespace s2nnds::program {
namespace {

struct Key {
  std::string name, value, expected;
};

// Collects the keys that a configuration has, in the order of visits.
class KeyCollector final : public FieldVisitor {
 public:
  using FieldVisitor::field;
  void field(std::string_view name, bool& value) override {
    add(name, value ? "true" : "false", "true, false");
  }
  void field(std::string_view name, std::int64_t& value, Range range) override {
    add(name, fmt::format("{}", value), "integer, " + range.describe());
  }
  void field(std::string_view name, double& value, Range range) override {
    add(name, fmt::format("{}", value), range.describe());
  }
  void field(std::string_view name, std::string& value, const std::vector<std::string>& choices) override {
    add(name, fmt::format("\"{}\"", value),
        choices.empty() ? "text" : fmt::format("{}", fmt::join(choices, ", ")));
  }
  void field(std::string_view name, std::vector<double>& value, Range range) override {
    add(name, fmt::format("[{}]", fmt::join(value, ", ")), "list, each " + range.describe());
  }
  void field(std::string_view name, std::vector<std::int64_t>& value, Range range) override {
    add(name, fmt::format("[{}]", fmt::join(value, ", ")), "list of integers, each " + range.describe());
  }
  void field(std::string_view name, std::vector<std::string>& value) override {
    add(name, fmt::format("[{}]", fmt::join(value, ", ")), "list of texts");
  }
  void field(std::string_view name, std::vector<std::vector<double>>& value, Range range) override {
    add(name, fmt::format("{}", value), "list of lists, each " + range.describe());
  }
  void field(std::string_view name, WordOrNumbers& value, const std::vector<std::string>& words) override {
    add(name,
        value.word.empty() ? fmt::format("[{}]", fmt::join(value.numbers, ", "))
                           : fmt::format("\"{}\"", value.word),
        fmt::format("{}, or list of numbers", fmt::join(words, ", ")));
  }

  const std::vector<Key>& keys() const { return keys_; }

 protected:
  void begin_group(std::string_view name) override { path_.push_back(std::string(name) + "."); }
  void end_group() override { path_.pop_back(); }
  void visit_list(std::string_view name, StructList&) override { add(name, "[]", "list of tables"); }

 private:
  void add(std::string_view name, std::string value, std::string expected) {
    keys_.push_back({fmt::format("{}{}", fmt::join(path_, ""), name), std::move(value), std::move(expected)});
  }

  std::vector<std::string> path_;
  std::vector<Key> keys_;
};

std::vector<Key> keys_of(Config config) {
  KeyCollector collector;
  config.visit(collector);
  return collector.keys();
}

// The choices of a text field, as messages list them.
std::vector<std::string> choices_of(const std::vector<Key>& keys, std::string_view name) {
  std::vector<std::string> choices;
  for (const Key& key : keys) {
    if (key.name != name) continue;
    std::string word;
    for (char c : key.expected + ",") {
      if (c == ',')
        choices.push_back(std::exchange(word, {}));
      else if (c != ' ')
        word += c;
    }
  }
  return choices;
}

class KeyTable {
 public:
  // Adds the keys that are new, as those which `when` brings.
  void add(const Config& config, const std::string& when) {
    for (const Key& key : keys_of(config)) {
      if (!known_.emplace(key.name, rows_.size()).second) continue;
      rows_.push_back(
          {{"key", key.name}, {"default", key.value}, {"expected", key.expected}, {"when", when}});
    }
  }
  void add_profile(const std::string& profile) {
    for (const Key& key : keys_of(default_config(profile))) {
      const auto known = known_.find(key.name);
      if (key.name == "profile" || known == known_.end() || rows_[known->second]["default"] == key.value)
        continue;
      rows_[known->second][profile] = key.value;
    }
  }
  const nlohmann::ordered_json& rows() const { return rows_; }

 private:
  std::map<std::string, std::size_t> known_;
  nlohmann::ordered_json rows_ = nlohmann::ordered_json::array();
};

}  // namespace

int keys() {
  const Config robust;
  const std::vector<Key> all = keys_of(robust);
  KeyTable table;
  table.add(robust, "");
  for (const std::string& source : choices_of(all, "data.source")) {
    Config config;
    config.data.source = source;
    table.add(config, fmt::format("data.source = \"{}\"", source));
  }
  Config pose;
  pose.data.source = "csv";
  pose.data.state = "pose";
  table.add(pose, "data.state = \"pose\"");
  for (const std::string& type : choices_of(all, "problem.unsafe.type")) {
    Config config;
    config.problem.unsafe.type = type;
    table.add(config, fmt::format("type = \"{}\"", type));
  }
  for (const std::string profile : {"smooth", "paper", "imitation"}) {
    table.add(default_config(profile), fmt::format("profile = \"{}\"", profile));
    table.add_profile(profile);
  }
  fmt::print("{}\n", s2nnds::json_text(table.rows(), 1));
  return 0;
}

}  // namespace s2nnds::program
