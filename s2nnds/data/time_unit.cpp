// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/time_unit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "s2nnds/core/check.h"
#include "s2nnds/data/column_names.h"
#include "s2nnds/data/quantile.h"

namespace s2nnds {
namespace {

struct TimeUnit {
  std::string_view name;
  double seconds;
};
constexpr std::array<TimeUnit, 4> kUnits = {{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};
using Fits = std::array<bool, kUnits.size()>;

// What tells the unit: the times of one recording.
struct Times {
  double first = 0;     // with the offset
  double duration = 0;  // of the finite ones
  double step = 0;      // 90 % of the steps are no longer: bursts make most of them tiny
  double speed = 0;     // median of |change of position| / |change of time|
  double recorded = 0;  // median of the recorded |velocity|, 0: none
};

Times times_of(const Recording& r) {
  std::vector<double> steps, speeds, recorded;
  double low = 0, high = 0;
  Eigen::Index last = -1;
  for (Eigen::Index i = 0; i < r.time.size(); ++i) {
    if (!std::isfinite(r.time[i])) continue;
    low = last < 0 ? r.time[i] : std::min(low, r.time[i]);
    high = last < 0 ? r.time[i] : std::max(high, r.time[i]);
    if (last >= 0 && r.time[i] > r.time[last]) {
      steps.push_back(r.time[i] - r.time[last]);
      const double moved = (r.position.row(i) - r.position.row(last)).norm();
      if (moved > 0) speeds.push_back(moved / steps.back());
      if (r.velocity.size() > 0 && moved > 0) recorded.push_back(r.velocity.row(i).norm());
    }
    last = i;
  }
  std::erase_if(recorded, [](double speed) { return !std::isfinite(speed); });
  return {r.time_offset + low, high - low, quantile(std::move(steps), 0.9), quantile(std::move(speeds), 0.5),
          quantile(std::move(recorded), 0.5)};
}

bool within(double value, double low, double high) { return value >= low && value <= high; }

template <typename Rule>
Fits fitting(const std::vector<Times>& all, const Rule& rule) {
  Fits fits{};
  for (std::size_t u = 0; u < kUnits.size(); ++u) {
    fits[u] = std::all_of(all.begin(), all.end(),
                          [&](const Times& times) { return rule(times, kUnits[u].seconds); });
  }
  return fits;
}

std::ptrdiff_t count(const Fits& fits) { return std::count(fits.begin(), fits.end(), true); }

std::size_t the_one(const Fits& fits) {
  return static_cast<std::size_t>(std::find(fits.begin(), fits.end(), true) - fits.begin());
}

// Of 1 s to 1 h on the clock of 2001 to 2096.
bool of_this_century(const Times& t, double unit) {
  return within(t.first * unit, 1e9, 4e9) && within(t.duration * unit, 0.01, 3600);
}
bool as_recorded(const Times& t, double unit) {
  return t.recorded > 0 && t.speed > 0 && within(t.speed / unit / t.recorded, 0.2, 5);
}
bool likely(const Times& t, double unit) {
  return within(t.duration * unit, 0.5, 120) && within(t.step * unit, 5e-4, 0.3);
}
bool possible(const Times& t, double unit) {
  return within(t.duration * unit, 0.05, 3600) && within(t.step * unit, 5e-5, 2);
}

struct Choice {
  std::size_t unit = 0;  // into kUnits
  std::string reason;
};

Choice recognise(const RecordingSet& set) {
  const std::string& column = set.recordings.front().time_column;
  const std::string named = time_unit_in_name(column);
  for (std::size_t u = 0; u < kUnits.size(); ++u)
    if (kUnits[u].name == named) return {u, "by its name"};
  std::vector<Times> all;
  for (const Recording& r : set.recordings) all.push_back(times_of(r));
  struct Rule {
    bool (*holds)(const Times&, double);
    std::string_view reason;
    bool decides;  // whether two units at once are an error
  };
  constexpr std::array<Rule, 4> rules = {{{of_this_century, "by its size, counted from 1970", false},
                                          {as_recorded, "by the recorded velocities", false},
                                          {likely, "by its size", true},
                                          {possible, "by its size", true}}};
  for (const Rule& rule : rules) {
    const Fits fits = fitting(all, rule.holds);
    if (count(fits) == 1) return {the_one(fits), std::string(rule.reason)};
    check(count(fits) == 0 || !rule.decides,
          "{}: found times that may be {} or {} (column '{}': {:g} in all, steps of {:g}); expected "
          "data.time_unit to say which",
          set.recordings.front().where, kUnits[the_one(fits)].name, kUnits[the_one(fits) + 1].name, column,
          all.front().duration, all.front().step);
    for (std::size_t k = 0; k < all.size() && rule.decides && count(fits) == 0; ++k) {
      const Fits mine = fitting({all[k]}, rule.holds);
      const Fits first = fitting({all.front()}, rule.holds);
      check(mine == first || count(mine) != 1 || count(first) != 1,
            "{}: found times (column '{}') as large as {}, those of {} as {}; expected one unit of time in "
            "all demonstrations",
            set.recordings[k].where, set.recordings[k].time_column, kUnits[the_one(mine)].name,
            set.recordings.front().where, kUnits[the_one(first)].name);
    }
  }
  return {};
}

}  // namespace

void bring_to_seconds(RecordingSet& set, const std::string& unit) {
  if (set.time_unit > 0 || set.recordings.empty()) return;
  Choice choice;
  if (unit == "auto") {
    choice = recognise(set);
  } else {
    while (choice.unit < kUnits.size() && kUnits[choice.unit].name != unit) ++choice.unit;
    check(choice.unit < kUnits.size(), "data.time_unit: found '{}'; expected auto, s, ms, us or ns", unit);
  }
  set.time_unit = kUnits[choice.unit].seconds;
  for (Recording& r : set.recordings) {
    if (set.time_unit != 1.0) r.time *= set.time_unit;
    r.time_offset *= set.time_unit;
  }
  if (unit == "auto" && choice.unit > 0) {
    set.report.push_back(fmt::format("time column '{}' taken as {} ({}); data.time_unit says otherwise",
                                     set.recordings.front().time_column, kUnits[choice.unit].name,
                                     choice.reason));
  }
}

}  // namespace s2nnds
