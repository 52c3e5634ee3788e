// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

// For control loops: C++17, the standard library alone, no allocation, no exception.

namespace s2nnds {

// Passive interaction control (Kronander and Billard, IEEE RA-L 2016): a robot's end follows xdot = f(x) and gives way
// to whoever pushes it,
//   force = D(x) (f(x) - v) + feed-forward,  D with `along` in the direction of f(x) and `across` in all others,
// where f, which is no gradient of an energy, and the feed-forward draw on a tank: what they put into the robot, damping
// has taken out before, but for what the tank holds at first. An empty tank leaves the damping alone.
//
// Motion is the type of that name in an exported header: positions in the policy's unit and frame.
template <typename Motion>
class PassiveController {
 public:
  static constexpr int dimension = Motion::dimension;  // n

  struct Settings {
    double metres_per_unit = 1.0;  // of the policy's unit of length, > 0
    double period = 0.001;         // s between calls of step(), > 0
    double along = 100.0;          // N s/m: damping in the direction of f, > 0
    double across = 100.0;         // N s/m: the same in all others, > 0
    double mass = 0.0;         // kg: effective mass whose acceleration along f is fed forward, >= 0; 0: none
    double most_force = 50.0;  // N: the force is scaled down to this, > 0
    double tank_capacity = 10.0;  // J, > 0
    double tank_start = 5.0;      // J, in [0, tank_capacity]
  };

  // What one call answers.
  struct Command {
    double force[dimension] = {};  // N
    double tank = 0.0;             // J left
    double drive = 0.0;            // share of f and the feed-forward that the tank allowed, in [0, 1]
    bool stopped = false;          // a reading was not finite, now or before: damping alone until reset()
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
    valid_ = positive(settings.metres_per_unit) && positive(settings.period) && positive(settings.along) &&
             positive(settings.across) && positive(settings.most_force) && positive(settings.tank_capacity) &&
             settings.mass >= 0.0 && std::isfinite(settings.mass) && settings.tank_start >= 0.0 &&
             settings.tank_start <= settings.tank_capacity;
    reset();
  }

  bool valid() const noexcept { return valid_; }  // the settings are within their ranges

  // Fills the tank to its start and forgets a stop.
  void reset() noexcept {
    tank_ = valid_ ? settings_.tank_start : 0.0;
    stopped_ = !valid_;
    started_ = false;
  }

  // The force at the position x [n] and velocity v [n], in the policy's unit (per second). To be called once a period;
  // the force is to be held until the next call.
  Command step(const double* x, const double* v) noexcept {
    Command command;
    double f[dimension] = {};
    bool finite = true;
    for (int i = 0; i < dimension; ++i) finite = finite && std::isfinite(x[i]) && std::isfinite(v[i]);
    if (finite) Motion::velocity(x, f);
    for (int i = 0; i < dimension; ++i) finite = finite && std::isfinite(f[i]);
    if (!finite) stopped_ = true;
    if (stopped_) return stop(v, command);
    const double metres = settings_.metres_per_unit;
    settle_tank(x);
    double fed[dimension] = {};
    feed_forward(x, v, f, fed);
    double speed = 0.0, forward = 0.0, power = 0.0;
    for (int i = 0; i < dimension; ++i) {
      f[i] *= Motion::execution_speed * metres;
      speed += f[i] * f[i];
      forward += f[i] * v[i] * metres;
    }
    for (int i = 0; i < dimension; ++i) {
      drive_[i] = settings_.along * f[i] + fed[i];
      power += drive_[i] * v[i] * metres;
      // D v: `across` of it, and the rest in the direction of f.
      const double part = speed > 0.0 ? (settings_.along - settings_.across) * forward / speed * f[i] : 0.0;
      damping_[i] = -(settings_.across * v[i] * metres + part);
    }
    // What one period may draw. A tank that is empty still lets the drive brake.
    command.drive = 1.0;
    if (power > 0.0) command.drive = std::min(1.0, std::max(0.0, tank_) / (power * settings_.period));
    double size = 0.0;
    for (int i = 0; i < dimension; ++i) {
      drive_[i] *= command.drive;
      command.force[i] = drive_[i] + damping_[i];
      size += command.force[i] * command.force[i];
    }
    const double share = std::min(1.0, settings_.most_force / std::sqrt(std::max(size, 1e-300)));
    for (int i = 0; i < dimension; ++i) {
      drive_[i] *= share;
      damping_[i] *= share;
      command.force[i] *= share;
      last_[i] = x[i];
    }
    started_ = true;
    command.tank = tank_;
    return command;
  }

  // Whether the certificate covers the state x, v [n], in the policy's unit (per second). False for NaN.
  static Coverage monitor(const double* x, const double* v) noexcept {
    Coverage found;
    double f[dimension] = {};
    Motion::velocity(x, f);
    double square = 0.0;
    for (int i = 0; i < dimension; ++i) {
      const double off = v[i] - Motion::execution_speed * f[i];
      square += off * off;
    }
    found.deviation = std::sqrt(square);
    found.allowed = Motion::execution_speed * Motion::disturbance_margin;
    found.safe = Motion::safe(x);
    found.covered = found.safe && found.deviation < found.allowed;
    return found;
  }

 private:
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

  Command& stop(const double* v, Command& command) const noexcept {
    command.stopped = true;
    command.tank = tank_;
    double size = 0.0;
    for (int i = 0; i < dimension; ++i) {
      command.force[i] =
          valid_ && std::isfinite(v[i]) ? -settings_.across * v[i] * settings_.metres_per_unit : 0.0;
      size += command.force[i] * command.force[i];
    }
    if (size > settings_.most_force * settings_.most_force) {
      for (double& force : command.force) force *= settings_.most_force / std::sqrt(size);
    }
    return command;
  }

  Settings settings_;
  bool valid_ = false, stopped_ = true, started_ = false;
  double tank_ = 0.0;
  double drive_[dimension] = {}, damping_[dimension] = {}, last_[dimension] = {};  // of the last call
};

}  // namespace s2nnds
