// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/phase.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr double kLeastLoop = 0.1;  // of the extent: a smaller loop can be left out
constexpr double kAtEnd = 0.05;     // of the extent: so near to its end a motion x' = f(x) goes there
constexpr double kOvershoot =
    0.25;  // of the extent: who comes back from a place less far away may end early as well

// Whether the demonstration goes far away from the crossing before it comes back to it.
bool is_large(const Crossing& crossing, const Demonstration& d, double extent) {
  for (Eigen::Index i = 0; i < d.samples(); ++i) {
    const double time = d.time[i] - d.time[0];
    if (time < crossing.first_time || time > crossing.second_time) continue;
    if ((d.position.row(i) - crossing.place.transpose()).norm() > kLeastLoop * extent) return true;
  }
  return false;
}

// Whether the demonstration is at its end before, and goes away from there again.
bool passes_end(const Demonstration& d, double extent) {
  const Vector distance = (d.position.rowwise() - d.position.row(d.samples() - 1)).rowwise().norm();
  bool was_there = false;
  for (const double each : distance) {
    if (was_there && each > kOvershoot * extent) return true;
    was_there = was_there || each < kAtEnd * extent;
  }
  return false;
}

// The integral of |v| up to each sample, by the trapezoidal rule: [M].
Vector path_length(const Demonstration& d) {
  const Vector speed = d.velocity.rowwise().norm();
  Vector length = Vector::Zero(d.samples());
  for (Eigen::Index i = 1; i < d.samples(); ++i)
    length[i] = length[i - 1] + 0.5 * (speed[i - 1] + speed[i]) * (d.time[i] - d.time[i - 1]);
  return length;
}

Points beside(const Points& left, const Vector& right) {
  Points both(left.rows(), left.cols() + 1);
  both << left, right;
  return both;
}

}  // namespace

PhaseChoice choose_phase(const std::string& state, const DemonstrationSet& set, const Survey& found) {
  if (state == "phase")
    return {true,
            fmt::format("data.state: phase, as asked for: states (x, s) in {} dimensions{}",
                        set.dimension() + 1, set.dimension() > 2 ? ", in which a proof may not end" : "")};
  if (state != "auto" || set.dimension() != 2) return {};
  const auto count = static_cast<Eigen::Index>(set.demonstrations.size());
  std::vector<bool> closed(set.demonstrations.size()), crosses(set.demonstrations.size());
  for (Eigen::Index k = 0; k < count; ++k)
    closed[static_cast<std::size_t>(k)] =
        found.is_closed(k) || passes_end(set.demonstrations[static_cast<std::size_t>(k)], found.extent);
  for (const Crossing& each : found.crossings) {
    crosses[each.first] =
        crosses[each.first] ||
        (each.first == each.second && is_large(each, set.demonstrations[each.first], found.extent));
  }
  Eigen::Index close = 0, cross = 0, either = 0;
  for (std::size_t k = 0; k < set.demonstrations.size(); ++k) {
    close += closed[k] ? 1 : 0;
    cross += crosses[k] ? 1 : 0;
    either += closed[k] || crosses[k] ? 1 : 0;
  }
  if (2 * either < count) return {};
  const std::string what = close >= cross
                               ? fmt::format("{} of {} end where they start or were before", close, count)
                               : fmt::format("{} of {} cross themselves", cross, count);
  return {true,
          fmt::format("data.state: auto chose phase, since of the demonstrations {}: states (x, s), s the "
                      "part of the path that is left",
                      what)};
}

Frame add_phase(DemonstrationSet& set, const Frame& frame) {
  Frame states = frame;
  states.phase_start = 0.0;
  std::vector<Vector> lengths;
  for (const Demonstration& d : set.demonstrations) {
    lengths.push_back(path_length(d));
    const double whole = lengths.back()[d.samples() - 1];
    check(whole > 0.0 && std::isfinite(whole),
          "data.state: demonstration {} has velocities whose integral is {}; expected a motion, of which a "
          "phase can be made",
          lengths.size() - 1, whole);
    states.phase_start += whole / static_cast<double>(set.demonstrations.size());
  }
  for (std::size_t k = 0; k < set.demonstrations.size(); ++k) {
    Demonstration& d = set.demonstrations[k];
    const Vector& length = lengths[k];
    const double whole = length[d.samples() - 1];
    const Vector rate = -states.phase_start / whole * d.velocity.rowwise().norm();
    d.position = beside(d.position, states.phase_start * (1.0 - length.array() / whole));
    d.velocity = beside(d.velocity, rate);
    const Vector fastest =
        frame.normalization == "max_norm" ? Vector(d.velocity.rowwise().norm()) : Vector(rate.cwiseAbs());
    states.velocity_scale = std::max(states.velocity_scale, fastest.maxCoeff());
  }
  states.goal.conservativeResize(frame.goal.size() + 1);
  states.goal[frame.goal.size()] = 0.0;
  states.goals = beside(frame.goals, Vector::Zero(frame.goals.rows()));
  return states;
}

Frame find_state(DemonstrationSet& set, const std::string& state, const std::string& normalization,
                 const WordOrNumbers& goal) {
  const Frame frame = find_frame(set, normalization, goal);
  if (state == "position" || state == "pose" || state == "joints") return frame;
  const PhaseChoice choice = choose_phase(state, set, survey(set));
  if (!choice.used) return frame;
  set.report.push_back(choice.reason);
  return add_phase(set, frame);
}

}  // namespace s2nnds
