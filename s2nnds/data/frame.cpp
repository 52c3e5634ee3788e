// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/frame.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/data/orientation.h"

namespace s2nnds {
namespace {

double scale_of(const std::string& normalization, const Points& points) {
  return normalization == "max_norm" ? points.rowwise().norm().maxCoeff() : points.cwiseAbs().maxCoeff();
}

bool is_scale(double value) { return value > 0.0 && std::isfinite(value); }

// The last positions: [K, n].
Points ends_of(const std::vector<Demonstration>& demonstrations, Eigen::Index dimension) {
  Points ends(static_cast<Eigen::Index>(demonstrations.size()), dimension);
  for (Eigen::Index k = 0; k < ends.rows(); ++k) {
    ends.row(k) = demonstrations[static_cast<std::size_t>(k)].position.bottomRows(1);
  }
  return ends;
}

// Of equal rows their value, bit for bit.
Vector mean_row(const Points& rows) {
  const Eigen::RowVectorXd first = rows.row(0);
  return (first + (rows.rowwise() - first).colwise().mean()).transpose();
}

Vector goal_of(const WordOrNumbers& goal, const Points& ends) {
  if (!goal.word.empty()) {
    check(goal.word == "mean" || goal.word == "each",
          "data.goal: found \"{}\"; expected mean, each or a point such as [0.5, 0.2]", goal.word);
    return mean_row(ends);
  }
  check(std::ssize(goal.numbers) == ends.cols(),
        "data.goal: found {} coordinates; expected {} as the positions", goal.numbers.size(), ends.cols());
  const Vector point = Eigen::Map<const Vector>(goal.numbers.data(), ends.cols());
  check(point.allFinite(), "data.goal: found ({}); expected finite coordinates",
        fmt::join(goal.numbers, ", "));
  return point;
}

// Only where no demonstration is moved: each must end at the goal, or the motion that is learned would not
// be the one that was shown.
void check_ends(Frame frame, const DemonstrationSet& as_read, bool named) {
  const Points all = stack_positions(as_read.demonstrations);
  const double extent = (all.colwise().maxCoeff() - all.colwise().minCoeff()).maxCoeff();
  Eigen::Index farthest = 0;
  const double distance = frame.end_distances(as_read.demonstrations).maxCoeff(&farthest);
  if (distance <= largest_end_share * extent) return;
  const std::string unit = frame.unit.empty() ? "" : " " + frame.unit;
  frame.position_scale = extent;  // says how many digits are shown
  fail(
      "data.goal: demonstration {} ends {:.4g}{} from the goal {}, {}: found {:.0f} % of the "
      "motion's "
      "extent of {:.4g}{}, expected at most {:.0f} %; choose data.goal = \"each\" (moves every demonstration "
      "to "
      "end at one goal), a point for data.goal, or the demonstrations that end there (data.use)",
      farthest, distance, unit, frame.position_text(frame.goal),
      named ? "which data.goal names" : "the mean of all ends", 100.0 * distance / extent, extent, unit,
      100.0 * largest_end_share);
}

// Where a sample stands in its file, as far as that is known.
std::string sample_text(const Demonstration& d, Eigen::Index i) {
  const std::string line =
      d.lines.empty() ? "" : fmt::format(" (line {})", d.lines[static_cast<std::size_t>(i)]);
  return fmt::format("sample {}{}", i, line);
}

// The mean of the last orientations, which all must be near to, and from which none may be turned by 180 degrees.
Vector goal_orientation(const std::vector<Demonstration>& demonstrations) {
  Points ends(static_cast<Eigen::Index>(demonstrations.size()), 4);
  for (Eigen::Index k = 0; k < ends.rows(); ++k)
    ends.row(k) = demonstrations[static_cast<std::size_t>(k)].orientation.bottomRows(1);
  const Eigen::Vector4d goal = mean_orientation(ends);
  constexpr double most = 175.0 * M_PI / 180.0;
  for (std::size_t k = 0; k < demonstrations.size(); ++k) {
    const Demonstration& d = demonstrations[k];
    const double end = angle_between(goal, ends.row(static_cast<Eigen::Index>(k)).transpose());
    check(end <= largest_end_turn,
          "orientation: demonstration {} ends turned by {:.0f} degrees from the mean of all ends; expected "
          "at most "
          "{:.0f}: choose those that end alike (data.use), or name the order of its quaternions "
          "(data.quaternion_order)",
          k, degrees(end), degrees(largest_end_turn));
    for (Eigen::Index i = 0; i < d.samples(); ++i) {
      const double turn = angle_between(goal, d.orientation.row(i).transpose());
      check(turn < most,
            "orientation: demonstration {} is turned by {:.0f} degrees from the goal's orientation at {}; "
            "expected "
            "less than {:.0f}, where rotation vectors do not jump",
            k, degrees(turn), sample_text(d, i), degrees(most));
    }
  }
  return goal;
}

}  // namespace

std::vector<Demonstration> Frame::normalize(const std::vector<Demonstration>& as_read) const {
  s2nnds::check(static_cast<Eigen::Index>(as_read.size()) == goals.rows(),
                "frame: found {} demonstrations, expected {} as its goals", as_read.size(), goals.rows());
  std::vector<Demonstration> normalized = as_read;
  for (std::size_t k = 0; k < normalized.size(); ++k) {
    Demonstration& d = normalized[k];
    d.time.array() -= double(d.time[0]);
    d.time /= time_scale();
    d.position.rowwise() -= goals.row(static_cast<Eigen::Index>(k));
    d.position /= position_scale;
    d.velocity /= velocity_scale;
  }
  return normalized;
}

Points Frame::to_data(const Points& normalised) const {
  return (position_scale * normalised).rowwise() + goal.transpose();
}

Vector Frame::to_data(const Vector& normalised) const { return goal + position_scale * normalised; }

std::string Frame::position_text(const Vector& position, Rounding rounding) const {
  // Tens above, since 10^-k is no double.
  const double places = 5.0 - std::floor(std::log10(position_scale));
  const double finer = std::pow(10.0, std::max(places, 0.0)),
               coarser = std::pow(10.0, std::max(-places, 0.0));
  std::vector<double> shown;
  for (const double coordinate : position) {
    const double steps = coordinate * finer / coarser;
    const double whole = rounding == Rounding::nearest ? std::round(steps)
                         : rounding == Rounding::up    ? std::ceil(steps)
                                                       : std::floor(steps);
    shown.push_back(whole * coarser / finer + 0.0);  // no -0
  }
  const std::string in_unit = unit.empty() ? "" : " " + unit;
  const bool phased = has_phase() && position.size() == goal.size();
  const std::string place =
      fmt::format("({}){}", fmt::join(shown.begin(), shown.end() - phased, ", "), in_unit);
  return phased ? fmt::format("{}, s = {}{}", place, shown.back(), in_unit) : place;
}

Frame Frame::of_places() const {
  Frame frame = *this;
  frame.goal = goal.head(places());
  frame.goals = goals.leftCols(places());
  frame.phase_start = 0.0;
  return frame;
}

Vector Frame::end_distances(const std::vector<Demonstration>& as_read) const {
  return (ends_of(as_read, goal.size()).rowwise() - goal.transpose()).rowwise().norm();
}

bool Frame::moves_demonstrations() const {
  return (goals.array() != goal.transpose().replicate(goals.rows(), 1).array()).any();
}

void Frame::check(std::size_t count, Eigen::Index dimension, const std::string& where) const {
  s2nnds::check(is_scale(position_scale) && is_scale(velocity_scale),
                "{}: found position_scale {} and velocity_scale {}, expected numbers > 0", where,
                position_scale, velocity_scale);
  s2nnds::check(goals.rows() == static_cast<Eigen::Index>(count) && goals.cols() == dimension,
                "{}: found goals [{}, {}], expected [{}, {}]", where, goals.rows(), goals.cols(), count,
                dimension);
  s2nnds::check(goal.size() == dimension, "{}: found a goal of {} coordinates, expected {}", where,
                goal.size(), dimension);
  s2nnds::check(goal_orientation.size() == 0 ||
                    (goal_orientation.size() == 4 && std::abs(goal_orientation.norm() - 1.0) <= 1e-9),
                "{}: found a goal orientation that is no unit quaternion", where);
  s2nnds::check(goal_orientation.size() == 0 || quaternion_order == "xyzw" || quaternion_order == "wxyz",
                "{}: found the quaternion order '{}', expected xyzw or wxyz", where, quaternion_order);
  s2nnds::check(phase_start >= 0.0 && std::isfinite(phase_start) && places() > 0,
                "{}: found phase_start {} in {} dimensions, expected a number >= 0", where, phase_start,
                dimension);
  s2nnds::check(goal.allFinite() && goals.allFinite(),
                "{}: found a goal that is NaN or infinite, expected finite numbers", where);
}

Frame find_frame(const DemonstrationSet& as_read, const std::string& normalization,
                 const WordOrNumbers& goal) {
  check(normalization == "max_abs" || normalization == "max_norm",
        "normalization: found '{}'; expected max_abs or max_norm", normalization);
  const Points ends = ends_of(as_read.demonstrations, as_read.dimension());
  Frame frame{.unit = as_read.unit, .name = {}, .normalization = normalization, .goal = {}, .goals = ends};
  frame.goal = goal_of(goal, ends);
  if (goal.word != "each") {
    check_ends(frame, as_read, goal.word.empty());
    frame.goals.rowwise() = frame.goal.transpose();
  }
  if (as_read.demonstrations.front().orientation.size() > 0) {
    frame.goal_orientation = goal_orientation(as_read.demonstrations);
    frame.quaternion_order = as_read.quaternion_order;
  }
  const std::vector<Demonstration> from_goal = frame.normalize(as_read.demonstrations);  // scales of 1
  frame.position_scale = scale_of(normalization, stack_positions(from_goal));
  frame.velocity_scale = scale_of(normalization, stack_velocities(from_goal));
  check(frame.position_scale > 0 && frame.velocity_scale > 0,
        "normalization: found largest position {} and velocity {}; expected a motion, both > 0",
        frame.position_scale, frame.velocity_scale);
  return frame;
}

}  // namespace s2nnds
