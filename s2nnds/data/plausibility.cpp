// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/plausibility.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

double extent_of(const Demonstration& d) {
  return (d.position.colwise().maxCoeff() - d.position.colwise().minCoeff()).norm();
}

// In `unit` per second; nothing where the unit is not known.
std::optional<double> fastest_in(const std::string& unit) {
  if (unit == "m") return 20;
  if (unit == "cm") return 2e3;
  if (unit == "mm") return 2e4;
  if (unit == "rad") return 50;
  if (unit == "deg") return 50 * 180 / M_PI;
  return std::nullopt;
}

struct Columns {
  const std::string& time;
  std::string text() const { return time.empty() ? "" : fmt::format(" (time column '{}')", time); }
};

void check_speed(const Demonstration& d, const std::string& where, const std::string& unit,
                 const Columns& columns, double largest_extent, double stated) {
  const std::optional<double> of_unit = fastest_in(unit);
  const double bound = stated > 0 ? stated : of_unit.value_or(100 * largest_extent);
  Eigen::Index place = 0;
  const double speed = d.velocity.rowwise().norm().maxCoeff(&place);
  check(speed <= bound,
        "{}: found a speed of {:.4g} {}/s at {:.6g} s{}; expected at most {:.4g}: time stamps or a unit are "
        "wrong (data.time_unit, data.unit, data.cleaning, data.limits.speed)",
        where, speed, unit.empty() ? "units" : unit, d.time[place] - d.time[0], columns.text(), bound);
}

// The way by recorded velocities against that by positions, both in some fifty pieces, so that neither is what noise
// adds from one sample to the next.
void check_recorded(const Demonstration& d, const std::string& where, const Columns& columns) {
  constexpr Eigen::Index kPieces = 50;
  const Eigen::Index last = d.samples() - 1, piece = std::max<Eigen::Index>(1, last / kPieces);
  double differences = 0, recorded = 0;
  for (Eigen::Index first = 0; first < last; first += piece) {
    const Eigen::Index end = std::min(last, first + piece);
    Eigen::RowVectorXd way = Eigen::RowVectorXd::Zero(d.dimension());
    for (Eigen::Index i = first; i < end; ++i)
      way += 0.5 * (d.time[i + 1] - d.time[i]) * (d.velocity.row(i) + d.velocity.row(i + 1));
    differences += (d.position.row(end) - d.position.row(first)).norm();
    recorded += way.norm();
  }
  if (!(differences > 0)) return;
  const double ratio = recorded / differences;
  check(ratio >= 0.2 && ratio <= 5,
        "{}: found recorded velocities {:.4g} times those that positions and times give{}; expected the same "
        "unit (data.time_unit, data.columns.velocity)",
        where, ratio, columns.text());
}

void check_extents(const DemonstrationSet& set, double bound) {
  std::vector<double> extents;
  for (const Demonstration& d : set.demonstrations) extents.push_back(extent_of(d));
  const auto [small, large] = std::minmax_element(extents.begin(), extents.end());
  check(*large <= bound * *small,
        "{}: found demonstration {} {:.4g} and demonstration {} {:.4g} large; expected at most {:.4g} times: "
        "one unit for all (data.use leaves one out, data.limits.extents)",
        set.name, small - extents.begin(), *small, large - extents.begin(), *large, bound);
}

}  // namespace

void PlausibilityOptions::visit(FieldVisitor& v) {
  v.field("duration", duration, above(0));
  v.field("speed", speed, at_least(0));
  v.field("extents", extents, at_least(1));
}

void check_plausible(const DemonstrationSet& set, const std::vector<std::string>& time_columns,
                     const PlausibilityOptions& options) {
  double largest = 0;
  for (const Demonstration& d : set.demonstrations) largest = std::max(largest, extent_of(d));
  check(largest > 0, "{}: found demonstrations that do not move; expected a motion", set.name);
  check_extents(set, options.extents);
  for (std::size_t k = 0; k < set.demonstrations.size(); ++k) {
    const Demonstration& d = set.demonstrations[k];
    const std::string where = fmt::format("{}: demonstration {}", set.name, k);
    const Columns columns{time_columns[k]};
    const double duration = d.time[d.samples() - 1] - d.time[0];
    check(duration <= options.duration,
          "{}: found a duration of {:.4g} s{}; expected at most {:.4g} s (data.time_unit, "
          "data.limits.duration)",
          where, duration, columns.text(), options.duration);
    check_speed(d, where, set.unit, columns, largest, options.speed);
    check_recorded(d, where, columns);
  }
}

}  // namespace s2nnds
