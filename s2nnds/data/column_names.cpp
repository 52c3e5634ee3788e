// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/column_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>
#include <string_view>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"

namespace s2nnds {
namespace {

using Names = std::vector<std::string>;
constexpr std::string_view kParts = "xyzw";  // of a quaternion

bool is_one_of(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

bool has_one_of(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](std::string_view word) { return text.find(word) != std::string_view::npos; });
}

// What stands in brackets at the end: "x [mm]" -> "mm".
std::string bracketed(std::string_view name) {
  const auto open = name.find_last_of("[(");
  const auto close = name.find_last_of("])");
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) return "";
  return std::string(name.substr(open + 1, close - open - 1));
}

// Lower case, without brackets, everything that is no letter or digit one underscore:
// "/robot/pose/position/x [m]" -> "robot_pose_position_x".
std::string plain(std::string_view name) {
  if (!bracketed(name).empty()) name = name.substr(0, name.find_last_of("[("));
  std::string text;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter)) {
      text += static_cast<char>(std::tolower(letter));
    } else if (!text.empty() && text.back() != '_') {
      text += '_';
    }
  }
  while (text.ends_with('_')) text.pop_back();
  return text;
}

// A plain name without the unit at its end, which goes to `unit`: "x_mm" -> "x".
std::string without_unit(std::string name, std::string& unit) {
  for (const std::string_view known : {"mm", "cm", "m", "rad", "deg"}) {
    const std::string end = "_" + std::string(known);
    if (!name.ends_with(end)) continue;
    unit = known;
    return name.substr(0, name.size() - end.size());
  }
  return name;
}

bool is_time_word(std::string_view name) {
  return is_one_of(name, {"t",
                          "time",
                          "times",
                          "timestamp",
                          "timestamps",
                          "time_stamp",
                          "stamp",
                          "sec",
                          "secs",
                          "second",
                          "seconds",
                          "msec",
                          "usec",
                          "nsec",
                          "ms",
                          "us",
                          "ns",
                          "elapsed",
                          "elapsed_time",
                          "header_stamp",
                          "field_header_stamp",
                          "rosbagtimestamp"});
}

bool is_time(std::string_view name) {
  if (is_time_word(name)) return true;
  const auto end = name.rfind('_');
  return end != std::string_view::npos && !time_unit_in_name(std::string(name)).empty() &&
         is_time_word(name.substr(0, end));
}

bool is_index(std::string_view name) {
  return is_one_of(name, {"episode", "episode_index", "episode_id", "demo", "demo_id", "demo_index",
                          "demonstration", "demonstration_id", "traj", "traj_id", "trajectory",
                          "trajectory_id", "trial", "trial_id", "run_id"});
}

// A group of columns that differ in the axis alone: x, y, z or a number.
struct Group {
  std::string stem;                           // the name with '#' for the axis: "pos_#", "#"
  std::map<std::string, std::size_t> places;  // by axis
  std::string unit;
};

bool is_velocity(std::string_view stem) {
  if (has_one_of(stem, {"ang", "acc", "rot", "cmd", "desired"})) return false;
  return is_one_of(stem, {"v#", "d#", "v_#", "d_#", "#d", "#_d", "dq#", "qd#", "dx#", "vx#", "xd#", "dq_#",
                          "qd_#", "dp#", "dp_#"}) ||
         has_one_of(stem, {"vel", "speed", "dot", "twist", "linear"});
}

bool is_position(std::string_view stem) {
  return !is_velocity(stem) &&
         !is_one_of(stem, {"w#", "w_#", "a#", "a_#", "f#", "f_#", "m#", "n#", "t#", "d#", "tau#", "tau_#"}) &&
         !has_one_of(stem,
                     {"acc", "orient", "quat", "rot", "ang", "force", "torque", "wrench", "effort", "rpy",
                      "euler", "mag", "gyro", "imu", "cov", "normal", "cmd", "desired", "target"});
}

// Best first: the plain ones, then those that say that they are positions.
int rank_of_position(std::string_view stem) {
  if (is_one_of(stem, {"#"})) return 0;
  if (is_one_of(stem, {"p#", "p_#", "x#", "x_#", "pos#", "pos_#", "position_#", "position#"})) return 1;
  return has_one_of(stem, {"pos", "transl"}) ? 2 : 3;
}

void add(std::vector<Group>& groups, const std::string& name, std::size_t begin, std::size_t size,
         std::size_t place, const std::string& unit) {
  const std::string stem = name.substr(0, begin) + "#" + name.substr(begin + size);
  auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.stem == stem; });
  if (group == groups.end()) group = groups.insert(groups.end(), Group{stem, {}, unit});
  group->places.emplace(name.substr(begin, size), place);
}

bool is_axis(char c) { return c >= 'x' && c <= 'z'; }

// Groups by the letters x, y, z at the end of a name or before an underscore at its beginning.
std::vector<Group> lettered(const Names& names) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::string unit = bracketed(names[i]);
    const std::string name = without_unit(plain(names[i]), unit);
    if (name.empty()) continue;
    if (is_axis(name.back())) {
      add(groups, name, name.size() - 1, 1, i, unit);
    } else if (is_axis(name[0]) && name.size() > 1 && name[1] == '_') {
      add(groups, name, 0, 1, i, unit);
    } else if (is_axis(name[0]) && (name.substr(1) == "dot" || name.substr(1) == "d")) {
      add(groups, name, 0, 1, i, unit);
    }
  }
  std::erase_if(groups, [](const Group& g) { return !g.places.contains("x") || !g.places.contains("y"); });
  return groups;
}

// Groups by the last number in a name, which counts without a hole from 0 or 1.
std::vector<Group> numbered(const Names& names) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::string unit = bracketed(names[i]);
    const std::string name = without_unit(plain(names[i]), unit);
    const auto last = name.find_last_of("0123456789");
    if (last == std::string::npos) continue;
    const auto before = name.find_last_not_of("0123456789", last);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    if (begin == 0 || last + 1 - begin > 3) continue;
    add(groups, name, begin, last + 1 - begin, i, unit);
  }
  std::erase_if(groups, [](const Group& g) {
    const int first = g.places.contains("0") ? 0 : 1;
    for (int k = 0; k < static_cast<int>(g.places.size()); ++k)
      if (!g.places.contains(std::to_string(first + k))) return true;
    return g.places.size() < 2;
  });
  return groups;
}

std::vector<std::size_t> in_order(const Group& group) {
  std::vector<std::pair<std::pair<std::size_t, std::string>, std::size_t>> keyed;  // 2 before 10
  for (const auto& [axis, place] : group.places) keyed.push_back({{axis.size(), axis}, place});
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::size_t> places;
  for (const auto& [key, place] : keyed) places.push_back(place);
  return places;
}

std::string quoted(const Names& names) {
  constexpr std::size_t kMost = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    text += fmt::format("{}'{}'", i > 0 ? ", " : "", printable(names[i], 60));
  return names.size() > kMost ? fmt::format("{} and {} more", text, names.size() - kMost) : text;
}

class Finder {
 public:
  Finder(const Names& names, bool named, const ColumnOptions& wanted, const std::string& where)
      : names_(names), named_(named), wanted_(wanted), where_(where) {}

  std::size_t place(const std::string& wanted, std::string_view key) const {
    for (const bool exact : {true, false}) {
      for (std::size_t i = 0; i < names_.size(); ++i) {
        if (exact ? names_[i] == wanted : plain(names_[i]) == plain(wanted) && !plain(wanted).empty())
          return i;
      }
    }
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
    const bool is_number = error == std::errc() && end == wanted.data() + wanted.size();
    check(is_number && number < names_.size(),
          "{}: found the {} columns {}; expected '{}' as data.columns.{} says, a name or a number from 0",
          where_, names_.size(), quoted(names_), printable(wanted, 200), key);
    return number;
  }

  std::optional<std::size_t> time() const {
    if (!wanted_.time.empty()) return place(wanted_.time, "time");
    if (!named_) return 0;
    std::optional<std::size_t> best;
    for (std::size_t i = names_.size(); i-- > 0;) {
      if (!is_time(plain(names_[i]))) continue;
      // A stamp inside a message yields to the column that is the time itself.
      if (!best || !is_one_of(plain(names_[i]), {"stamp", "header_stamp", "field_header_stamp"})) best = i;
    }
    check(best.has_value(),
          "{}: found the columns {}; expected a time column: name it by data.columns.time, or give data.rate",
          where_, quoted(names_));
    return best;
  }

  std::vector<std::size_t> position(bool timed, std::string& unit) const {
    if (!wanted_.position.empty()) return places(wanted_.position, "position");
    if (!named_) return numbers_after(timed);
    for (const std::vector<Group>& groups : {lettered(names_), numbered(names_)}) {
      std::vector<const Group*> best;
      for (const Group& group : groups) {
        if (!is_position(group.stem)) continue;
        const int rank = rank_of_position(group.stem);
        if (!best.empty() && rank_of_position(best.front()->stem) < rank) continue;
        if (!best.empty() && rank_of_position(best.front()->stem) > rank) best.clear();
        best.push_back(&group);
      }
      if (best.empty()) continue;
      check(best.size() == 1,
            "{}: found more than one group of position columns in {}; expected data.columns.position to name "
            "one",
            where_, quoted(names_));
      unit = best.front()->unit;
      return in_order(*best.front());
    }
    fail("{}: found the columns {}; expected position columns: name them by data.columns.position", where_,
         quoted(names_));
  }

  std::vector<std::size_t> velocity(std::size_t dimension) const {
    if (wanted_.velocity == Names{"none"}) return {};
    if (!wanted_.velocity.empty()) return places(wanted_.velocity, "velocity");
    if (!named_ || !wanted_.position.empty()) return {};
    for (const std::vector<Group>& groups : {lettered(names_), numbered(names_)}) {
      std::vector<const Group*> found;
      for (const Group& group : groups)
        if (is_velocity(group.stem) && group.places.size() == dimension) found.push_back(&group);
      if (found.size() == 1) return in_order(*found.front());
    }
    return {};
  }

  // Those of a quaternion or a rotation matrix that are named, else of a quaternion whose names tell its parts.
  std::vector<std::size_t> orientation(std::string& order) const {
    check(wanted_.quaternion.empty() || wanted_.rotation.empty(),
          "{}: found data.columns.quaternion and data.columns.rotation; expected one of them", where_);
    const auto check_count = [&](const Names& wanted, std::size_t count, std::string_view key) {
      check(wanted.size() == count, "{}: found {} columns in data.columns.{}; expected {}", where_,
            wanted.size(), key, count);
    };
    if (!wanted_.rotation.empty()) {
      check_count(wanted_.rotation, 9, "rotation");
      return places(wanted_.rotation, "rotation");
    }
    if (!wanted_.quaternion.empty()) {
      check_count(wanted_.quaternion, 4, "quaternion");
      const std::vector<std::size_t> found = places(wanted_.quaternion, "quaternion");
      std::string letters;
      for (const std::size_t place : found)
        letters += plain(names_[place]).empty() ? ' ' : plain(names_[place]).back();
      if (letters == "xyzw" || letters == "wxyz") order = letters;
      return found;
    }
    return quaternion_by_letters(order);
  }

  std::optional<std::size_t> index() const {
    if (!wanted_.index.empty()) return place(wanted_.index, "index");
    for (std::size_t i = 0; named_ && i < names_.size(); ++i)
      if (is_index(plain(names_[i]))) return i;
    return std::nullopt;
  }

 private:
  // The one group of names that end in x, y, z and w, in the order of the file.
  std::vector<std::size_t> quaternion_by_letters(std::string& order) const {
    std::map<std::string, std::map<char, std::size_t>> groups;
    for (std::size_t i = 0; named_ && i < names_.size(); ++i) {
      const std::string name = plain(names_[i]);
      if (name.size() > 1) groups[name.substr(0, name.size() - 1)].emplace(name.back(), i);
    }
    std::vector<std::size_t> found;
    for (const auto& [stem, parts] : groups) {
      const bool whole =
          std::all_of(kParts.begin(), kParts.end(), [&there = parts](char c) { return there.contains(c); });
      const bool is_one = stem == "q" || stem == "q_" || has_one_of(stem, {"quat", "orient", "rot"});
      if (!whole || !is_one) continue;
      if (!found.empty()) return {};  // not clear
      order = parts.at('w') < parts.at('x') ? "wxyz" : "xyzw";
      for (const char part : order) found.push_back(parts.at(part));
    }
    return found;
  }

  std::vector<std::size_t> places(const Names& wanted, std::string_view key) const {
    std::vector<std::size_t> found;
    for (const std::string& name : wanted) found.push_back(place(name, key));
    return found;
  }

  std::vector<std::size_t> numbers_after(bool timed) const {
    std::vector<std::size_t> rest;
    for (std::size_t i = 0; i < names_.size(); ++i)
      if (!(timed && wanted_.time.empty() && i == 0)) rest.push_back(i);
    check(wanted_.time.empty() && (rest.size() == 2 || rest.size() == 3),
          "{}: found no header and {} columns; expected data.columns to name them by their numbers, as in "
          "{{ time = \"0\", position = [\"1\", \"2\"] }}",
          where_, names_.size());
    return rest;
  }

  const Names& names_;
  bool named_;
  const ColumnOptions& wanted_;
  const std::string& where_;
};

}  // namespace

void ColumnOptions::visit(FieldVisitor& v) {
  v.field("time", time);
  v.field("position", position);
  v.field("velocity", velocity);
  v.field("index", index);
  v.field("quaternion", quaternion);
  v.field("rotation", rotation);
}

Columns find_columns(const std::vector<std::string>& names, bool named, bool timed,
                     const ColumnOptions& wanted, const std::string& where) {
  const Finder finder(names, named, wanted, where);
  Columns columns;
  if (timed) columns.time = finder.time();
  columns.index = finder.index();
  columns.position = finder.position(timed, columns.unit);
  check(columns.position.size() >= 2,
        "{}: found {} position column(s); expected at least 2 (data.columns.position)", where,
        columns.position.size());
  columns.orientation = finder.orientation(columns.quaternion_order);
  columns.velocity = finder.velocity(columns.position.size());
  check(columns.velocity.empty() || columns.velocity.size() == columns.position.size(),
        "{}: found {} velocity column(s) for {} position columns; expected as many (data.columns.velocity)",
        where, columns.velocity.size(), columns.position.size());
  if (!is_one_of(columns.unit, {"m", "mm", "cm", "rad", "deg"})) columns.unit.clear();
  return columns;
}

std::string describe(const Columns& columns, const std::vector<std::string>& names) {
  std::vector<bool> used(names.size(), false);
  const auto name = [&](std::size_t place) {
    used[place] = true;
    return names[place];
  };
  const auto list = [&](const std::vector<std::size_t>& places) {
    Names taken;
    for (const std::size_t place : places) taken.push_back(name(place));
    return quoted(taken);
  };
  std::string text = columns.time ? fmt::format("time '{}', ", name(*columns.time)) : "no time, ";
  text += "position " + list(columns.position);
  text += columns.velocity.empty() ? ", no velocity" : ", velocity " + list(columns.velocity);
  if (!columns.orientation.empty())
    text += (columns.orientation.size() == 9 ? ", rotation matrix " : ", quaternion ") +
            list(columns.orientation);
  if (columns.index) text += fmt::format(", demonstrations by '{}'", name(*columns.index));
  Names rest;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!used[i]) rest.push_back(names[i]);
  return rest.empty() ? text : text + ", not used " + quoted(rest);
}

std::string time_unit_in_name(const std::string& name) {
  const std::string inside = bracketed(name);
  const std::string text = inside.empty() ? plain(name) : plain(inside);
  const std::string last = text.substr(text.rfind('_') + 1);  // npos + 1 is 0
  if (is_one_of(last, {"ns", "nsec", "nsecs", "nanosec", "nanosecs", "nanosecond", "nanoseconds"}))
    return "ns";
  if (is_one_of(last, {"us", "usec", "usecs", "microsec", "microsecond", "microseconds"})) return "us";
  if (is_one_of(last, {"ms", "msec", "msecs", "millisec", "millisecond", "milliseconds"})) return "ms";
  if (is_one_of(last, {"s", "sec", "secs", "second", "seconds"})) return "s";
  return "";
}

}  // namespace s2nnds
