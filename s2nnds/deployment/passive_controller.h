// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

// For control loops: C++17, the standard library alone, no allocation, no exception.

namespace s2nnds {

// Why a PassiveController has stopped: what it was told is beyond what a certificate can speak of, or makes no sense.
enum class SafeStop {
  none,
  settings,   // out of range
  reading,    // a position or velocity is not finite
  workspace,  // the position lies outside of the workspace
  late,       // longest_period or more since the last call
  old,        // the reading is longest_delay old or more
  fast        // the robot is as fast as `fastest` or faster
};

// One line for a log: "stopped: ...".
inline const char* in_words(SafeStop stop) noexcept {
  switch (stop) {
    case SafeStop::none:
      return "running";
    case SafeStop::settings:
      return "stopped: found settings out of range";
    case SafeStop::reading:
      return "stopped: found a position or velocity that is not finite";
    case SafeStop::workspace:
      return "stopped: found a position outside of the workspace";
    case SafeStop::late:
      return "stopped: found a call later than the longest period";
    case SafeStop::old:
      return "stopped: found a reading older than the longest delay";
    case SafeStop::fast:
      return "stopped: found a velocity above the fastest";
  }
  return "";
}

// Passive interaction control (Kronander and Billard, IEEE RA-L 2016): a robot's end follows xdot = f(x) and gives way
// to whoever pushes it,
//   force = D(x) (f(x) - v) + feed-forward,  D with `along` in the direction of f(x) and `across` in all others,
// where f, which is no gradient of an energy, and the feed-forward draw on a tank: what they put into the robot, damping
// has taken out before, but for what the tank holds at first. They draw no more in a period than the tank holds, at any
// velocity up to `fastest`, so they never take it below zero. An empty tank leaves the damping alone.
//
// Motion is the type of that name in an exported header: positions in the policy's unit and frame.
template <typename Motion>
class PassiveController {
 public:
  static constexpr int dimension = Motion::dimension;  // n

  struct Settings {
    double metres_per_unit = 1.0;   // of the policy's unit of length, > 0
    double period = 0.001;          // s between calls of step(), > 0
    double longest_period = 0.004;  // s, > period: a later call is a safe stop
    double longest_delay = 0.004;   // s, > 0: an older reading is a safe stop
    double along = 100.0;           // N s/m: damping in the direction of f, > 0
    double across = 100.0;          // N s/m: the same in all others, > 0
    double mass = 0.0;         // kg: effective mass whose acceleration along f is fed forward, >= 0; 0: none
    double most_force = 50.0;  // N: the force is scaled down to this, > 0
    double fastest = 1.5;      // m/s, > 0: a faster robot is a safe stop
    double tank_capacity = 10.0;  // J, > 0
    double tank_start = 5.0;      // J, in [0, tank_capacity]
  };

  // What one call answers.
  struct Command {
    double force[dimension] = {};    // N
    double tank = 0.0;               // J left
    double drive = 0.0;              // share of f and the feed-forward that the tank allowed, in [0, 1]
    SafeStop stop = SafeStop::none;  // otherwise damping alone, from that call on until reset()
  };

  // What is known of a state.
  struct Coverage {
    bool safe = false;       // x lies in the safe set
    double deviation = 0.0;  // |v - speed f(x)|, in the policy's unit per second
    double allowed = 0.0;    // the certified margin for it, scaled by the speed
    // Both hold: as long as they do, the certificate says that the robot stays in the safe set.
    bool covered = false;
  };

  // Settings out of range, or NaN, leave the controller stopped for good.
  explicit PassiveController(const Settings& settings) noexcept : settings_(settings) {
    const auto positive = [](double value) { return value > 0.0 && std::isfinite(value); };
    valid_ = positive(settings.metres_per_unit) && positive(settings.period) &&
             settings.longest_period > settings.period && std::isfinite(settings.longest_period) &&
             positive(settings.longest_delay) && positive(settings.along) && positive(settings.across) &&
             positive(settings.most_force) && positive(settings.fastest) &&
             positive(settings.tank_capacity) && settings.mass >= 0.0 && std::isfinite(settings.mass) &&
             settings.tank_start >= 0.0 && settings.tank_start <= settings.tank_capacity;
    reset();
  }

  bool valid() const noexcept { return valid_; }  // the settings are within their ranges

  // Fills the tank to its start and forgets a stop.
  void reset() noexcept {
    tank_ = valid_ ? settings_.tank_start : 0.0;
    stop_ = valid_ ? SafeStop::none : SafeStop::settings;
    started_ = false;
  }

  // The force at the position x [n] and velocity v [n], in the policy's unit (per second). To be called once a period;
  // the force is to be held until the next call.
  Command step(const double* x, const double* v) noexcept { return step(x, v, settings_.period, 0.0); }

  // The same where the loop measures itself: `elapsed` s since the last call, the reading being `age` s old.
  Command step(const double* x, const double* v, double elapsed, double age) noexcept {
    Command command;
    double f[dimension] = {};
    if (stop_ == SafeStop::none) stop_ = reason_to_stop(x, v, elapsed, age, f);
    if (stop_ != SafeStop::none) return stopped(v, command);
    settle_tank(x);
    find_forces(x, v, f);
    const double drive = length(drive_), damping = length(damping_);
    // The most that a period can take: a force times the way at `fastest`.
    const double way = settings_.fastest * settings_.longest_period;
    const double left = std::max(0.0, tank_ - damping * way);
    command.drive = drive * way > left ? left / (drive * way) : 1.0;
    double force[dimension];
    for (int i = 0; i < dimension; ++i) {
      drive_[i] *= command.drive;
      force[i] = drive_[i] + damping_[i];
    }
    const double size = length(force);
    const double share = size > settings_.most_force ? settings_.most_force / size : 1.0;
    for (int i = 0; i < dimension; ++i) {
      drive_[i] *= share;
      damping_[i] *= share;
      command.force[i] = share * force[i];
      last_[i] = x[i];
    }
    started_ = true;
    command.tank = tank_;
    return command;
  }

  // Whether the certificate covers the state x, v [n], in the policy's unit (per second). False for NaN.
  static Coverage monitor(const double* x, const double* v) noexcept {
    Coverage found;
    double off[dimension] = {};
    Motion::velocity(x, off);
    for (int i = 0; i < dimension; ++i) off[i] = v[i] - Motion::execution_speed * off[i];
    found.deviation = length(off);
    found.allowed = Motion::execution_speed * Motion::disturbance_margin;
    found.safe = Motion::safe(x);
    found.covered = found.safe && found.deviation < found.allowed;
    return found;
  }

 private:
  static double length(const double* vector) noexcept {
    double square = 0.0;
    for (int i = 0; i < dimension; ++i) square += vector[i] * vector[i];
    return std::sqrt(square);
  }

  // Also f(x), where there is none.
  SafeStop reason_to_stop(const double* x, const double* v, double elapsed, double age,
                          double* f) const noexcept {
    bool finite = true;
    for (int i = 0; i < dimension; ++i) finite = finite && std::isfinite(x[i]) && std::isfinite(v[i]);
    if (!finite) return SafeStop::reading;
    if (!Motion::in_workspace(x)) return SafeStop::workspace;
    if (started_ && !(elapsed < settings_.longest_period)) return SafeStop::late;
    if (!(age < settings_.longest_delay)) return SafeStop::old;
    if (!(length(v) * settings_.metres_per_unit < settings_.fastest)) return SafeStop::fast;
    Motion::velocity(x, f);
    for (int i = 0; i < dimension; ++i) finite = finite && std::isfinite(f[i]);
    return finite ? SafeStop::none : SafeStop::reading;
  }

  // What the held forces did since the last call, by the way that the robot went.
  void settle_tank(const double* x) noexcept {
    if (!started_) return;
    double driven = 0.0, damped = 0.0;
    for (int i = 0; i < dimension; ++i) {
      const double way = (x[i] - last_[i]) * settings_.metres_per_unit;
      driven += drive_[i] * way;
      damped -= damping_[i] * way;
    }
    tank_ = std::min(settings_.tank_capacity, tank_ + damped - driven);
  }

  // drive = along speed f + feed-forward, damping = -D v.
  void find_forces(const double* x, const double* v, const double* f) noexcept {
    const double metres = settings_.metres_per_unit;
    double fed[dimension] = {};
    feed_forward(x, v, f, fed);
    double square = 0.0, forward = 0.0;
    for (int i = 0; i < dimension; ++i) {
      square += f[i] * f[i];
      forward += f[i] * v[i] * metres;
    }
    for (int i = 0; i < dimension; ++i) {
      drive_[i] = settings_.along * Motion::execution_speed * metres * f[i] + fed[i];
      // `across` of v, and the rest in the direction of f.
      const double part = square > 0.0 ? (settings_.along - settings_.across) * forward / square * f[i] : 0.0;
      damping_[i] = -(settings_.across * v[i] * metres + part);
    }
  }

  // mass d/dt (speed f) along the motion, by a difference over a few periods of it.
  void feed_forward(const double* x, const double* v, const double* f, double* fed) const noexcept {
    if (!(settings_.mass > 0.0)) return;
    constexpr double periods = 5.0;
    const double time = periods * settings_.period;
    double ahead[dimension], there[dimension] = {};
    for (int i = 0; i < dimension; ++i) ahead[i] = x[i] + time * v[i];
    Motion::velocity(ahead, there);
    for (int i = 0; i < dimension; ++i) {
      const double rate = Motion::execution_speed * (there[i] - f[i]) / time * settings_.metres_per_unit;
      fed[i] = std::isfinite(rate) ? settings_.mass * rate : 0.0;
    }
  }

  Command& stopped(const double* v, Command& command) const noexcept {
    command.stop = stop_;
    command.tank = tank_;
    for (int i = 0; i < dimension; ++i) {
      command.force[i] =
          valid_ && std::isfinite(v[i]) ? -settings_.across * v[i] * settings_.metres_per_unit : 0.0;
    }
    const double size = length(command.force);
    if (size > settings_.most_force) {
      for (double& force : command.force) force *= settings_.most_force / size;
    }
    return command;
  }

  Settings settings_;
  bool valid_ = false, started_ = false;
  SafeStop stop_ = SafeStop::settings;
  double tank_ = 0.0;
  double drive_[dimension] = {}, damping_[dimension] = {}, last_[dimension] = {};  // of the last call
};

}  // namespace s2nnds
