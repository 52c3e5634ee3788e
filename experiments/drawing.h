// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What drawing a certified motion with an arm needs, whether the arm is simulated (robot_drawing) or Franka's (fci_drawing).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "s2nnds/deployment/passive_controller.h"
#include "s2nnds/deployment/policy.h"
#include "s2nnds/deployment/task_space.h"
#include "s2nnds/networks/dynamics.h"
#include "s2nnds/networks/evaluator.h"

namespace s2nnds::experiment {

constexpr double kArrived = 0.03, kGettingGoing = 0.2;  // normalised; s
constexpr int kArmJoints = 7;
using Place = std::array<double, 3>;  // m, in the arm's base frame

// What an exported header calls Motion, of a run that is loaded.
template <int n>
struct LoadedMotion {
  static constexpr int dimension = n;
  static inline double execution_speed = 1.0, disturbance_margin = 0.0;
  static inline const Policy* policy = nullptr;
  static inline std::optional<BasicDynamicsEvaluator<double>> f;
  static inline std::optional<Evaluator> B;

  static void load(const Policy& loaded) {
    policy = &loaded;
    f.emplace(loaded.networks);
    B.emplace(loaded.networks.B);
    execution_speed = loaded.info.execution_speed;
    disturbance_margin = loaded.info.disturbance_margin;
  }
  static Points normalised(const double* x) {
    Points z(1, n);
    for (int i = 0; i < n; ++i)
      z(0, i) = (x[i] - policy->info.goal[static_cast<std::size_t>(i)]) / policy->info.position_scale;
    return z;
  }
  static void velocity(const double* x, double* v) noexcept {
    const Points y = f->value(normalised(x));
    for (int i = 0; i < n; ++i) v[i] = policy->info.velocity_scale * y(0, i);
  }
  static double barrier(const double* x) { return B->value(normalised(x))(0, 0); }
  static bool in_workspace(const double* x) noexcept {
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (!(x[i] >= policy->info.workspace[at] && x[i] <= policy->info.workspace[n + at])) return false;
    }
    return true;
  }
  static bool safe(const double* x) noexcept {
    return in_workspace(x) && barrier(x) <= -policy->info.barrier_float64_error;
  }
};

// Where the motion lies before the robot.
template <int n>
struct Paper {
  Place goal = n == 2 ? Place{0.5, 0.0, 0.3} : Place{0.45, 0.0, 0.4};  // m, base frame
  double metres = 0.0;                                                 // on the robot per unit of the data
  const PolicyInfo* info = nullptr;

  // `size`: m on the robot of the motion's largest coordinate.
  explicit Paper(const PolicyInfo& policy, double size = n == 2 ? 0.15 : 0.12)
      : metres(size / policy.position_scale), info(&policy) {}
  Place on_robot(const double* x) const {
    Place place = goal;
    for (std::size_t i = 0; i < n; ++i) place[i] += metres * (x[i] - info->goal[i]);
    return place;
  }
  std::array<double, n> on_paper(const Place& place) const {
    std::array<double, n> x;
    for (std::size_t i = 0; i < n; ++i) x[i] = info->goal[i] + (place[i] - goal[i]) / metres;
    return x;
  }
  std::array<double, n> rate_on_paper(const Place& velocity) const {
    std::array<double, n> v;
    for (std::size_t i = 0; i < n; ++i) v[i] = velocity[i] / metres;
    return v;
  }
};

template <int n>
using Vectors = std::vector<std::array<double, n>>;

template <int n>
double distance(const std::array<double, n>& a, const std::array<double, n>& b) {
  double square = 0.0;
  for (std::size_t i = 0; i < n; ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(square);
}

template <int n>
double normalised_goal_distance(const std::array<double, n>& x, const PolicyInfo& info) {
  std::array<double, n> goal;
  std::copy_n(info.goal.begin(), n, goal.begin());
  return distance<n>(x, goal) / info.position_scale;
}

// The motion of x' = speed f(x), every 5 ms until it arrives or for 60 s.
template <int n>
Vectors<n> ideal_motion(std::array<double, n> x, const PolicyInfo& info) {
  using Motion = LoadedMotion<n>;
  constexpr double step = 0.005;
  Vectors<n> path = {x};
  while (path.size() < 12000 && normalised_goal_distance<n>(x, info) > 0.5 * kArrived) {
    std::array<double, n> half = x, slope;
    Motion::velocity(x.data(), slope.data());
    for (std::size_t i = 0; i < n; ++i) half[i] += 0.5 * step * Motion::execution_speed * slope[i];
    Motion::velocity(half.data(), slope.data());
    for (std::size_t i = 0; i < n; ++i) x[i] += step * Motion::execution_speed * slope[i];
    path.push_back(x);
  }
  return path;
}

// What else runs on the machine does not count.
inline double processor_microseconds() {
  timespec now = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

// One motion as it was drawn.
struct Drawn {
  bool arrived = false, left = false;
  double largest_barrier = -1e300;
  double mean_path = 0.0, largest_path = 0.0;  // m on the robot
  double energy = 0.0;                         // J drawn from the tank, at most
  std::vector<double> deviations, microseconds;
  long covered = 0, ticks = 0, measured = 0;
  std::string stop;                               // why the controller stopped, if it did
  nlohmann::json path = nlohmann::json::array();  // in the data's unit, every 20 ms
};

// kg: what the tool shows, on average over the directions of the motion.
template <int n>
double mean_effective_mass(const ArmState<kArmJoints>& state) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    const double direction[3] = {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
    sum += effective_mass(state, direction);
  }
  return sum / n;
}

// The velocity of the tool, m/s in the base frame.
inline Place tool_velocity(const ArmState<kArmJoints>& state) {
  Place velocity = {};
  for (std::size_t i = 0; i < 3; ++i) {
    for (int j = 0; j < kArmJoints; ++j) velocity[i] += state.jacobian[i][j] * state.rate[j];
  }
  return velocity;
}

// Notes what is true after a tick, `seconds` after the first one: the tool's place and velocity.
template <int n>
void note(Drawn& drawn, double seconds, long tick, const Paper<n>& paper, const Vectors<n>& ideal,
          const Place& place, const Place& velocity) {
  using Motion = LoadedMotion<n>;
  const PolicyInfo& info = *paper.info;
  const auto x = paper.on_paper(place);
  const auto v = paper.rate_on_paper(velocity);
  const double barrier = Motion::barrier(x.data());
  drawn.largest_barrier = std::max(drawn.largest_barrier, barrier);
  drawn.left = drawn.left || !(barrier <= 0.0) || !Motion::in_workspace(x.data());
  drawn.arrived = normalised_goal_distance<n>(x, info) < kArrived;
  const auto coverage = PassiveController<Motion>::monitor(x.data(), v.data());
  if (seconds >= kGettingGoing) {
    drawn.deviations.push_back(coverage.deviation / info.velocity_scale);
    drawn.covered += coverage.covered;
    ++drawn.ticks;
  }
  if (tick % 20 != 0) return;
  drawn.path.push_back(x);
  double nearest = 1e300;
  for (const auto& y : ideal) nearest = std::min(nearest, distance<n>(x, y));
  drawn.mean_path += paper.metres * nearest;
  drawn.largest_path = std::max(drawn.largest_path, paper.metres * nearest);
  ++drawn.measured;
}

inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

inline std::vector<std::string> table_head() {
  return {"motion",    "control", "starts",  "arrive",  "leave",    "largest B", "|xdot-f| 99 %",
          "certified", "covered", "path mm", "largest", "energy J", "tick us",   "99.9 %"};
}

inline std::vector<std::string> row_of(const std::string& motion, const std::string& control,
                                       const std::string& starts, const std::vector<Drawn>& all,
                                       double certified) {
  std::vector<double> deviations, ticks;
  double largest = -1e300, energy = 0.0, mean_path = 0.0, largest_path = 0.0;
  long arrived = 0, left = 0, covered = 0, counted = 0;
  for (const Drawn& one : all) {
    deviations.insert(deviations.end(), one.deviations.begin(), one.deviations.end());
    ticks.insert(ticks.end(), one.microseconds.begin(), one.microseconds.end());
    largest = std::max(largest, one.largest_barrier);
    energy = std::max(energy, one.energy);
    mean_path += one.mean_path / static_cast<double>(all.size());
    largest_path = std::max(largest_path, one.largest_path);
    arrived += one.arrived;
    left += one.left;
    covered += one.covered;
    counted += one.ticks;
  }
  return {motion,
          control,
          starts,
          fmt::format("{}/{}", arrived, all.size()),
          fmt::format("{}", left),
          fmt::format("{:.3f}", largest),
          fmt::format("{:.3f}", quantile(deviations, 0.99)),
          fmt::format("{:.4f}", certified),
          fmt::format("{:.2f}", static_cast<double>(covered) / static_cast<double>(std::max(1L, counted))),
          fmt::format("{:.1f}", 1000.0 * mean_path),
          fmt::format("{:.1f}", 1000.0 * largest_path),
          fmt::format("{:.2f}", energy),
          fmt::format("{:.1f}", quantile(ticks, 0.5)),
          fmt::format("{:.1f}", quantile(ticks, 0.999))};
}

}  // namespace s2nnds::experiment
