// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "s2nnds/core/check.h"
#include "s2nnds/core/settings.h"
#include "s2nnds/core/toml_text.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A recursive struct whose keys depend on its type, as a region has.
struct Shape {
  std::string type = "none";
  double radius = 1.0;
  std::vector<double> lower = {};
  std::vector<Shape> of = {};

  void visit(FieldVisitor& v) {
    v.field("type", type, {"none", "ball", "box", "union"});
    if (type == "ball") v.field("radius", radius, above(0.0));
    if (type == "box") v.field("lower", lower, any_number());
    if (type == "union") v.list("of", of);
  }
  bool operator==(const Shape&) const = default;
};

struct Inner {
  std::int64_t depth = 2;
  Shape shape = {};

  void visit(FieldVisitor& v) {
    v.field("depth", depth, between(1, 8));
    v.group("shape", shape);
  }
  bool operator==(const Inner&) const = default;
};

struct Training {
  std::int64_t rounds = 30;
  double rate = 1e-3;
  double decay = 0.5;

  void visit(FieldVisitor& v) {
    v.field("rounds", rounds, at_least(1));
    v.field("rate", rate, above(0.0));
    v.field("decay", decay, Range{.low = 0.0, .high = 1.0, .open_high = true});
  }
  bool operator==(const Training&) const = default;
};

struct Settings {
  bool resume = false;
  std::int64_t seed = 0;
  double scale = 1.0;
  std::string name = "run";
  std::vector<double> weights = {1.0, 2.0};
  std::vector<std::int64_t> widths = {64, 64};
  std::vector<std::string> files;
  std::vector<std::vector<double>> corners = {{0.0, 1.0}};
  Training training;
  Inner inner;
  std::vector<Inner> inners;

  void visit(FieldVisitor& v) {
    v.field("resume", resume);
    v.group("training", training);  // a group before fields: TOML wants it after them
    v.field("seed", seed, any_number());
    v.field("scale", scale, any_number());
    v.field("name", name);
    v.field("weights", weights, at_least(0.0));
    v.field("widths", widths, above(0.0));
    v.field("files", files);
    v.field("corners", corners, at_least(-2.0));
    v.group("inner", inner);
    v.list("inners", inners);
  }
  bool operator==(const Settings&) const = default;
};

Settings unusual_settings() {
  Settings s;
  s.resume = true;
  s.seed = std::numeric_limits<std::int64_t>::min();
  s.scale = -kInfinity;
  s.name = "quote \" backslash \\ line\nbreak\ttab \x01 Größe";
  s.weights = {0.1, 1.0 / 3.0, 1e300, std::numeric_limits<double>::denorm_min(), 5.0, 1e22};
  s.widths = {std::numeric_limits<std::int64_t>::max(), 1};
  s.files = {"a b.csv", "", "c=d#e"};
  s.corners = {{1.0 / 3.0, -2.0}, {}, {5.0}};
  s.training = {.rounds = 7, .rate = std::nextafter(0.1, 1.0), .decay = 0.0};
  s.inner.depth = 8;
  s.inner.shape.type = "union";
  s.inner.shape.of = {{.type = "ball", .radius = 0.25},
                      {.type = "box", .lower = {-kInfinity, -0.0}},
                      {.type = "union", .of = {{.type = "ball", .radius = 3.0}, {.type = "none"}}}};
  s.inners = {{.depth = 3, .shape = {.type = "ball", .radius = 0.5}},
              {.depth = 4, .shape = {.type = "none"}}};
  return s;
}

std::string read_error(const std::string& text) {
  Settings settings = unusual_settings();
  try {
    read_toml(text, "my.toml", settings);
  } catch (const Error& error) {
    EXPECT_EQ(settings, unusual_settings()) << "a failed read must leave the options alone";
    return error.what();
  }
  return "no error";
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Options, ListsOfListsAreReadAndTheirFaultsNamed) {
  Settings settings;
  read_toml("corners = [[1, 2.5], []]", "my.toml", settings);
  EXPECT_EQ(settings.corners, (std::vector<std::vector<double>>{{1.0, 2.5}, {}}));
  EXPECT_EQ(
      read_error("corners = 1"),
      "my.toml:1: corners: expected a list of lists of numbers such as [[0, 0], [1, 0]], found an integer 1");
  EXPECT_EQ(read_error("corners = [[1, 2],\n [3, true]]"),
            "my.toml:2: corners[1]: expected a list of numbers, found a list of 2");
  EXPECT_EQ(read_error("corners = [[1, 2], [3, -4]]"),
            "my.toml:1: corners[1][1]: expected a number >= -2, found -4");
}

TEST(Range, HoldsAndDescribes) {
  EXPECT_TRUE(at_least(1).holds(1));
  EXPECT_FALSE(above(1).holds(1));
  EXPECT_TRUE(between(0, 1).holds(1));
  EXPECT_FALSE(inside(0, 1).holds(1));
  EXPECT_FALSE(inside(0, 1).holds(0));
  EXPECT_FALSE(at_least(1).holds(kInfinity));
  EXPECT_TRUE(any_number().holds(-kInfinity));
  for (const Range& range : {at_least(0), above(0), between(0, 1), inside(0, 1), any_number()}) {
    EXPECT_FALSE(range.holds(std::nan(""))) << range.describe();
  }
  EXPECT_EQ(at_least(1).describe(), "a number >= 1");
  EXPECT_EQ(above(0).describe(), "a number > 0");
  EXPECT_EQ((Range{.high = 2.5}).describe(), "a number <= 2.5");
  EXPECT_EQ((Range{.high = 2.5, .open_high = true}).describe(), "a number < 2.5");
  EXPECT_EQ(inside(0, 1).describe(), "a number in (0, 1)");
  EXPECT_EQ(between(-0.5, 1).describe(), "a number in [-0.5, 1]");
}

TEST(ReadToml, SetsWhatIsNamedAndKeepsTheRest) {
  Settings settings;
  read_toml(R"(
scale = 3          # an integer where a number is meant
weights = [1, 2.5]
[training]
rounds = 5
[inner.shape]
type = "union"
of = [{type = "ball", radius = 2}, {type = "none"}]
[[inners]]
depth = 5
[[inners]]
shape = {type = "box", lower = [-inf, 0]}
)",
            "my.toml", settings);
  Settings expected;
  expected.scale = 3.0;
  expected.weights = {1.0, 2.5};
  expected.training.rounds = 5;
  expected.inner.shape = {.type = "union", .of = {{.type = "ball", .radius = 2.0}, {.type = "none"}}};
  expected.inners = {{.depth = 5, .shape = {}},
                     {.depth = 2, .shape = {.type = "box", .lower = {-kInfinity, 0}}}};
  EXPECT_EQ(settings, expected);
}

TEST(ReadToml, ListsReplaceTheOldOnes) {
  Settings settings = unusual_settings();
  read_toml("inners = [{depth = 1}]\nfiles = []", "my.toml", settings);
  EXPECT_EQ(settings.inners, (std::vector<Inner>{{.depth = 1, .shape = {}}}));
  EXPECT_TRUE(settings.files.empty());
}

TEST(ReadToml, ShowsWordsOfTheFileShortAndOnOneLine) {
  const std::string longest(1'000'000, 'a');
  EXPECT_EQ(read_error("\"a\\nb\" = 1").substr(0, 27), "my.toml:1: unknown key a?b;");
  const std::vector<std::string> texts = {
      longest + " = 1", "seed = \"" + longest + "\"", "[inner.shape]\ntype = \"" + longest + "\"",
      longest + " = 1\n" + longest + " = 2", "\"a\\nb\" = 1\n\"a\\nb\" = 2"};
  for (const std::string& text : texts) {
    const std::string message = read_error(text);
    EXPECT_LT(message.size(), 600U);
    EXPECT_TRUE(std::none_of(message.begin(), message.end(), [](unsigned char c) { return c < 0x20; }))
        << message;
  }
}

TEST(ReadToml, SuggestsTheNearestKey) {
  EXPECT_EQ(read_error("\n[training]\nroundz = 3"),
            "my.toml:3: unknown key training.roundz; did you mean training.rounds?");
  EXPECT_EQ(read_error("[trianing]\nrounds = 3"), "my.toml:1: unknown key trianing; did you mean training?");
  EXPECT_EQ(read_error("rounds = 3"), "my.toml:1: unknown key rounds; did you mean training.rounds?");
  EXPECT_EQ(read_error("[inner.shape]\ntype = \"box\"\nradius = 1"),
            "my.toml:3: unknown key inner.shape.radius; expected one of type, lower");
  EXPECT_EQ(read_error("[[inners]]\n[[inners]]\ndepht = 1"),
            "my.toml:3: unknown key inners.1.depht; did you mean inners.1.depth?");
  EXPECT_EQ(read_error("inner = {shape = {type = \"union\", of = [\n{},\n{colour = 1}]}}"),
            "my.toml:3: unknown key inner.shape.of.1.colour; expected one of type");
}

TEST(ReadToml, SaysWhatTypeWasExpected) {
  EXPECT_EQ(read_error("[training]\nrounds = \"abc\""),
            "my.toml:2: training.rounds: expected an integer, found a string \"abc\"");
  EXPECT_EQ(read_error("seed = 1.0"), "my.toml:1: seed: expected an integer, found a number 1.0");
  EXPECT_EQ(read_error("scale = true"), "my.toml:1: scale: expected a number, found a truth value true");
  EXPECT_EQ(read_error("resume = 1"), "my.toml:1: resume: expected true or false, found an integer 1");
  EXPECT_EQ(read_error("name = 1979-05-27"),
            "my.toml:1: name: expected a string, found a date or time 1979-05-27");
  EXPECT_EQ(read_error("weights = 2"), "my.toml:1: weights: expected a list of numbers, found an integer 2");
  EXPECT_EQ(read_error("widths = [1,\n 2.5]"),
            "my.toml:2: widths[1]: expected an integer, found a number 2.5");
  EXPECT_EQ(read_error("files = \"a\""),
            "my.toml:1: files: expected a list of strings, found a string \"a\"");
  EXPECT_EQ(read_error("training = [1]"), "my.toml:1: training: expected a table, found a list of 1");
  EXPECT_EQ(read_error("inners = {}"), "my.toml:1: inners: expected a list of tables, found a table");
  EXPECT_EQ(read_error("inners = [3]"), "my.toml:1: inners.0: expected a table, found an integer 3");
}

TEST(ReadToml, SaysWhatRangeWasExpected) {
  EXPECT_EQ(read_error("[training]\nrounds = 0"),
            "my.toml:2: training.rounds: expected a number >= 1, found 0");
  EXPECT_EQ(read_error("[training]\nrate = inf"),
            "my.toml:2: training.rate: expected a number > 0, found inf");
  EXPECT_EQ(read_error("[training]\ndecay = 1.0"),
            "my.toml:2: training.decay: expected a number in [0, 1), found 1");
  EXPECT_EQ(read_error("scale = nan"), "my.toml:1: scale: expected a number, found nan");
  EXPECT_EQ(read_error("weights = [1, -1]"), "my.toml:1: weights[1]: expected a number >= 0, found -1");
  EXPECT_EQ(read_error("widths = [1, 0]"), "my.toml:1: widths[1]: expected a number > 0, found 0");
  EXPECT_EQ(read_error("[inner.shape]\ntype = \"bal\""),
            "my.toml:2: inner.shape.type: expected one of none, ball, box, union, found \"bal\"; did you "
            "mean ball?");
}

TEST(ReadToml, SaysWhereTextIsNotToml) {
  EXPECT_TRUE(read_error("seed = 1\nname = \"open").starts_with("my.toml:2: not TOML: "));
  EXPECT_TRUE(read_error("seed = 1\nseed = 2").starts_with("my.toml:2: not TOML: "));
  EXPECT_EQ(read_error("seed = 1\nname = \"open").find('\n'), std::string::npos);
}

TEST(ToToml, ReadsBackExactly) {
  const std::string text = to_toml(unusual_settings());
  Settings settings;
  read_toml(text, "written", settings);
  EXPECT_EQ(settings, unusual_settings()) << text;
  EXPECT_TRUE(std::signbit(settings.inner.shape.of[1].lower[1])) << text;
  EXPECT_EQ(to_toml(settings), text);
}

TEST(ToToml, RefusesNan) {
  Settings settings;
  settings.training.rate = std::nan("");
  EXPECT_EQ(error_of([&] { to_toml(settings); }), "training.rate: expected a number to write, found nan");
  settings = {};
  settings.weights = {1.0, std::nan("")};
  EXPECT_EQ(error_of([&] { to_toml(settings); }), "weights: expected a number to write, found nan");
}

TEST(ToJson, HoldsEveryField) {
  Settings settings = unusual_settings();
  settings.weights = {0.1, std::nan("")};
  const auto json = nlohmann::ordered_json::parse(to_json(settings));
  EXPECT_TRUE(json["resume"].get<bool>());
  EXPECT_EQ(json["seed"].get<std::int64_t>(), settings.seed);
  EXPECT_TRUE(json["scale"].is_null());
  EXPECT_EQ(json["name"].get<std::string>(), settings.name);
  EXPECT_EQ(json["weights"][0].get<double>(), 0.1);
  EXPECT_TRUE(json["weights"][1].is_null());
  EXPECT_EQ(json["training"]["rate"].get<double>(), settings.training.rate);
  EXPECT_EQ(json["inner"]["shape"]["of"][2]["of"][0]["radius"].get<double>(), 3.0);
  EXPECT_EQ(json["inners"].size(), 2u);
  EXPECT_EQ(json["files"], (std::vector<std::string>{"a b.csv", "", "c=d#e"}));
  EXPECT_EQ(json.begin().key(), "resume");
}

TEST(Validate, NamesFieldValueAndBound) {
  EXPECT_NO_THROW(validate(Settings{}));
  EXPECT_NO_THROW(validate(unusual_settings()));
  Settings settings;
  settings.training.rate = std::nan("");
  EXPECT_EQ(error_of([&] { validate(settings); }), "training.rate: expected a number > 0, found nan");
  settings = {};
  settings.inners.resize(2);
  settings.inners[1].depth = 9;
  EXPECT_EQ(error_of([&] { validate(settings); }), "inners.1.depth: expected a number in [1, 8], found 9");
  settings = {};
  settings.inner.shape.type = "sphere";
  EXPECT_EQ(error_of([&] { validate(settings); }),
            "inner.shape.type: expected one of none, ball, box, union, found \"sphere\"");
  settings = {};
  settings.widths = {64, -1};
  EXPECT_EQ(error_of([&] { validate(settings); }), "widths[1]: expected a number > 0, found -1");
}

TEST(Flatten, ListsDottedKeysInOrder) {
  Settings settings;
  settings.name = "plain \"text\"";
  settings.files = {"a"};
  settings.inner.shape.type = "union";
  settings.inner.shape.of = {{.type = "ball", .radius = 0.5}};
  const std::vector<std::pair<std::string, std::string>> expected = {{"resume", "false"},
                                                                     {"training.rounds", "30"},
                                                                     {"training.rate", "0.001"},
                                                                     {"training.decay", "0.5"},
                                                                     {"seed", "0"},
                                                                     {"scale", "1.0"},
                                                                     {"name", "plain \"text\""},
                                                                     {"weights", "[1.0, 2.0]"},
                                                                     {"widths", "[64, 64]"},
                                                                     {"files", "[\"a\"]"},
                                                                     {"corners", "[[0.0, 1.0]]"},
                                                                     {"inner.depth", "2"},
                                                                     {"inner.shape.type", "union"},
                                                                     {"inner.shape.of.0.type", "ball"},
                                                                     {"inner.shape.of.0.radius", "0.5"},
                                                                     {"inners", "[]"}};
  EXPECT_EQ(flatten(settings), expected);
}

Settings set(const std::string& text, const std::vector<std::string>& settings) {
  Settings options;
  read_toml(text, "my.toml", options, settings);
  // The text with the settings in it says the same.
  Settings again;
  read_toml(with_settings(text, "my.toml", settings), "again", again);
  EXPECT_EQ(again, options);
  return options;
}

std::string set_error(const std::string& text, const std::vector<std::string>& settings) {
  return error_of([&] { set(text, settings); });
}

TEST(Settings, SetOldAndNewKeys) {
  const std::string text = R"(seed = 1
"name" = "old"
[training]   # a comment
rounds = 5
[inner]
shape = {type = "ball", radius = 2}
[[inners]]
depth = 3
)";
  const Settings settings =
      set(text, {"seed=7", "training.rate = 1e-2", "training.rounds=6", "name=Sine wave", "weights=[1, 2, 3]",
                 "inner.shape.radius=0.5", "inners.0.depth=4", "resume=true", "files=[\"a.csv\"]", "seed=8"});
  Settings expected;
  expected.seed = 8;
  expected.name = "Sine wave";
  expected.training = {.rounds = 6, .rate = 1e-2};
  expected.weights = {1.0, 2.0, 3.0};
  expected.inner.shape = {.type = "ball", .radius = 0.5};
  expected.inners = {{.depth = 4, .shape = {}}};
  expected.resume = true;
  expected.files = {"a.csv"};
  EXPECT_EQ(settings, expected);
}

TEST(Settings, TextKeepsWhatItSays) {
  const std::string text = to_toml(unusual_settings());
  EXPECT_EQ(with_settings(text, "my.toml", {}), text);
  EXPECT_EQ(set(text, {"training.rounds=7"}), unusual_settings());
  EXPECT_TRUE(std::signbit(set(text, {"training.rounds=7"}).inner.shape.of[1].lower[1]));
}

TEST(Settings, MessagesNameTheLineOrTheSetting) {
  EXPECT_LT(set_error("seed = 1", {std::string(1'000'000, 'a')}).size(), 300U);
  const std::string text = "# head\n\nseed = 1\n\n[training]\nroundz = 3\nrate = 0.1\n";
  EXPECT_EQ(set_error(text, {"seed=2", "name=x"}),
            "my.toml:6: unknown key training.roundz; did you mean training.rounds?");
  EXPECT_EQ(set_error("\n\nweights = [1,\n2]\nseed = \"x\"", {"name=y"}),
            "my.toml:5: seed: expected an integer, found a string \"x\"");
  const std::string right = "seed = 1\n[training]\nrate = 0.1\n";
  EXPECT_EQ(set_error(right, {"training.roundz=3"}),
            "my.toml, setting: unknown key training.roundz; did you mean training.rounds?");
  EXPECT_EQ(set_error(right, {"inner={dept=3}"}),
            "my.toml, setting: unknown key inner.dept; did you mean inner.depth?");
  EXPECT_EQ(set_error(right, {"name=x", "training.rounds=0"}),
            "my.toml, setting: training.rounds: expected a number >= 1, found 0");
  EXPECT_EQ(set_error(right, {"weights=[1, -1]"}),
            "my.toml, setting: weights[1]: expected a number >= 0, found -1");
  EXPECT_EQ(set_error(right, {"seed=two"}),
            "my.toml, setting: seed: expected an integer, found a string \"two\"");
}

TEST(Settings, AValueThatIsNotTomlIsAString) {
  EXPECT_EQ(set("", {"name=paper"}).name, "paper");
  EXPECT_EQ(set("", {"inner.shape.type=ball"}).inner.shape.type, "ball");
  EXPECT_EQ(set("", {"name=one two"}).name, "one two");
  EXPECT_EQ(set("", {"name=a=b"}).name, "a=b");
  EXPECT_EQ(set("", {"name=\"3\""}).name, "3");
  EXPECT_EQ(set("", {"name="}).name, "");
  EXPECT_EQ(set("", {"name=1\nseed = 5"}).name, "1\nseed = 5");
}

// What toml++ writes in its other notations reads back to another text, or not at all.
TEST(Settings, TextsWithLineBreaksAndQuotesAreKept) {
  for (const std::string name :
       {"\nfirst", "\r\n", "a\n'''", "'''\n\\", "\"\n'''b", "\f\"\"\"", "\n \x7f\t"}) {
    EXPECT_EQ(set("name = " + string_text(name), {"seed=2"}).name, name);
    EXPECT_EQ(set("", {"name=" + string_text(name)}).name, name);
  }
}

TEST(Settings, WhatCannotBeSetIsRefused) {
  EXPECT_TRUE(set_error("", {"name=\xff"}).ends_with("expected text in UTF-8"));
  EXPECT_EQ(set_error("", {"seed"}), "setting \"seed\": expected key=value");
  EXPECT_EQ(set_error("", {"a..b=1"}), "setting \"a..b=1\": expected a dotted key before \"=\"");
  EXPECT_EQ(set_error("", {"=1"}), "setting \"=1\": expected a dotted key before \"=\"");
  EXPECT_EQ(set_error("seed = 1", {"seed.x=1"}), "setting \"seed.x=1\": there is no x to set");
  EXPECT_EQ(set_error("inners = [{}]", {"inners.1.depth=1"}),
            "setting \"inners.1.depth=1\": there is no 1 to set it in");
  EXPECT_EQ(set_error("seed = 1", {"seed.x.y=1"}), "setting \"seed.x.y=1\": there is no x to set it in");
  EXPECT_TRUE(error_of([] { with_settings("seed = ", "my.toml", {}); }).starts_with("my.toml:1: not TOML: "));
}

}  // namespace
}  // namespace s2nnds
