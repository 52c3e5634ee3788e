// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

// From forces at an arm's tool to torques at its joints. For control loops: C++17, the standard library alone, no allocation,
// no exception, and nothing of a particular robot: its state comes as plain numbers, from libfranka, a simulator or others.

namespace s2nnds {

// What a controller reads of an arm with `joints` joints, all in its base frame.
template <int joints>
struct ArmState {
  double q[joints] = {}, rate[joints] = {};                            // rad, rad/s
  double position[3] = {};                                             // m: of the tool
  double rotation[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};  // of the tool, row by row
  double jacobian[6][joints] = {};   // (velocity, angular velocity) of the tool by joint rates
  double mass[joints][joints] = {};  // kg m^2: the joints' mass matrix
  double bias[joints] = {};  // N m: what gravity (unless the robot makes up for it) and velocities ask for
};

// The solution of a x = b for a symmetric positive definite a, by its Cholesky factors, which replace its lower half. False
// where it is not positive definite (or not finite): then b is left half done.
template <int n>
bool solve_positive(double (&a)[n][n], double (&b)[n]) noexcept {
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k];
    if (!(a[j][j] > 0.0) || !std::isfinite(a[j][j])) return false;
    a[j][j] = std::sqrt(a[j][j]);
    for (int i = j + 1; i < n; ++i) {
      for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
      a[i][j] /= a[j][j];
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) b[i] -= a[k][i] * b[k];
    b[i] /= a[i][i];
  }
  return true;
}

// The rotation vector [3] that turns `from` into `to` (rotations [9], row by row) about axes of the base: log(to from'), of
// length up to pi.
inline void rotation_between(const double* from, const double* to, double* vector) noexcept {
  double r[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      r[i][j] = 0.0;
      for (int k = 0; k < 3; ++k) r[i][j] += to[3 * i + k] * from[3 * j + k];
    }
  }
  // sine * axis, of length sin(angle).
  const double s[3] = {0.5 * (r[2][1] - r[1][2]), 0.5 * (r[0][2] - r[2][0]), 0.5 * (r[1][0] - r[0][1])};
  const double sine = std::sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
  const double cosine = 0.5 * (r[0][0] + r[1][1] + r[2][2] - 1.0);
  const double angle = std::atan2(sine, cosine);
  if (sine > 1e-6 || cosine > 0.0) {
    for (int i = 0; i < 3; ++i) vector[i] = sine > 1e-12 ? angle / sine * s[i] : s[i];
    return;
  }
  // About half a turn: the axis is the longest column of r + 1, either way.
  int best = 0;
  for (int i = 1; i < 3; ++i) best = r[i][i] > r[best][best] ? i : best;
  double square = 0.0;
  for (int i = 0; i < 3; ++i) {
    vector[i] = r[i][best] + (i == best ? 1.0 : 0.0);
    square += vector[i] * vector[i];
  }
  for (int i = 0; i < 3; ++i) vector[i] *= angle / std::sqrt(square);
}

// kg: the mass that the tool shows to a force along `direction` (a unit vector [3]), 1 / (u' J M^-1 J' u). 0 if the mass
// matrix is not positive definite.
template <int joints>
double effective_mass(const ArmState<joints>& state, const double* direction) noexcept {
  double mass[joints][joints], along[joints], solved[joints], product = 0.0;
  for (int j = 0; j < joints; ++j) {
    along[j] = 0.0;
    for (int i = 0; i < 3; ++i) along[j] += state.jacobian[i][j] * direction[i];
    solved[j] = along[j];
    for (int k = 0; k < joints; ++k) mass[j][k] = state.mass[j][k];
  }
  if (!solve_positive(mass, solved)) return 0.0;
  for (int j = 0; j < joints; ++j) product += along[j] * solved[j];
  return product > 0.0 ? 1.0 / product : 0.0;
}

// Torques that do at the tool what a force asks for, hold its height (unless the force decides on that too) and its
// orientation like a spring and a damper, and draw the joints to a posture as far as the tool does not feel it:
//   torque = J' wrench + N posture + friction + bias, N = 1 - J' (J M^-1 J')^-1 J M^-1.
template <int joints>
class TaskSpaceController {
 public:
  struct Settings {
    double period = 0.001;             // s between calls, > 0
    double height_stiffness = 2000.0;  // N/m, >= 0
    double height_damping = 90.0;      // N s/m, >= 0
    double rotation_stiffness = 60.0;  // N m/rad, >= 0
    double rotation_damping = 6.0;     // N m s/rad, >= 0
    double posture_stiffness = 5.0;    // N m/rad, >= 0
    double posture_damping = 2.0;      // N m s/rad, >= 0
    double coulomb[joints] = {};       // N m of dry friction that is made up for, >= 0
    double viscous[joints] = {};       // N m s/rad, >= 0
    double friction_width = 0.01;      // rad/s: tanh(rate / this) stands for the rate's sign, > 0
    double most_torque[joints] = {};   // N m: limits of the joints, > 0
    double most_torque_rate = 1000.0;  // N m/s, > 0
  };

  // Where to.
  struct Goal {
    bool hold_height = true;  // else the force has all three directions
    double height = 0.0;      // m, of the tool
    double rotation[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    double posture[joints] = {};  // rad
  };

  struct Command {
    double torque[joints] = {};  // N m
    bool limited = false;        // a limit on torques or their rate was met
    bool stopped = false;  // the state or the settings make no sense: torques go to 0 at the limited rate
  };

  explicit TaskSpaceController(const Settings& settings) noexcept : settings_(settings) {
    const auto at_least = [](double value, double least) { return value >= least && std::isfinite(value); };
    constexpr double positive = 1e-300;
    valid_ = at_least(settings.period, positive) && at_least(settings.height_stiffness, 0.0) &&
             at_least(settings.height_damping, 0.0) && at_least(settings.rotation_stiffness, 0.0) &&
             at_least(settings.rotation_damping, 0.0) && at_least(settings.posture_stiffness, 0.0) &&
             at_least(settings.posture_damping, 0.0) && at_least(settings.friction_width, positive) &&
             at_least(settings.most_torque_rate, positive);
    for (int j = 0; j < joints; ++j) {
      valid_ = valid_ && at_least(settings.coulomb[j], 0.0) && at_least(settings.viscous[j], 0.0) &&
               at_least(settings.most_torque[j], positive);
    }
  }

  bool valid() const noexcept { return valid_; }

  // Begins from the torques [joints] that the robot holds at present.
  void reset(const double* torque) noexcept { std::copy_n(torque, joints, last_); }

  // To be called once a period with the force [3] in N that the tool is to feel, in the base frame.
  Command step(const ArmState<joints>& state, const double* force, const Goal& goal) noexcept {
    Command command;
    double torque[joints] = {};
    if (valid_) {
      add_tool_torques(state, force, goal, torque);
      add_posture_torques(state, goal, torque);
      for (int j = 0; j < joints; ++j) {
        torque[j] += settings_.coulomb[j] * std::tanh(state.rate[j] / settings_.friction_width) +
                     settings_.viscous[j] * state.rate[j] + state.bias[j];
      }
    }
    command.stopped = !valid_;
    for (const double value : torque) command.stopped = command.stopped || !std::isfinite(value);
    limit(torque, command);
    return command;
  }

 private:
  void add_tool_torques(const ArmState<joints>& state, const double* force, const Goal& goal,
                        double* torque) const noexcept {
    double velocity[6] = {}, wrench[6] = {force[0], force[1], force[2], 0.0, 0.0, 0.0}, turn[3];
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < joints; ++j) velocity[i] += state.jacobian[i][j] * state.rate[j];
    }
    if (goal.hold_height) {
      wrench[2] = settings_.height_stiffness * (goal.height - state.position[2]) -
                  settings_.height_damping * velocity[2];
    }
    rotation_between(state.rotation, goal.rotation, turn);
    for (int i = 0; i < 3; ++i)
      wrench[3 + i] = settings_.rotation_stiffness * turn[i] - settings_.rotation_damping * velocity[3 + i];
    for (int j = 0; j < joints; ++j) {
      for (int i = 0; i < 6; ++i) torque[j] += state.jacobian[i][j] * wrench[i];
    }
  }

  // N posture; none where the arm is singular, or has no joint to spare.
  void add_posture_torques(const ArmState<joints>& state, const Goal& goal, double* torque) const noexcept {
    double posture[joints], felt[6] = {}, seen[6][6];
    double accelerations[joints];  // M^-1 posture
    double columns[6][joints];     // M^-1 J', transposed
    for (int j = 0; j < joints; ++j) {
      posture[j] = settings_.posture_stiffness * (goal.posture[j] - state.q[j]) -
                   settings_.posture_damping * state.rate[j];
      accelerations[j] = posture[j];
    }
    if (!solve_mass(state, accelerations)) return;
    for (int i = 0; i < 6; ++i) {
      std::copy_n(state.jacobian[i], joints, columns[i]);
      if (!solve_mass(state, columns[i])) return;
    }
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < joints; ++j) felt[i] += state.jacobian[i][j] * accelerations[j];
      for (int k = 0; k < 6; ++k) {
        seen[i][k] = i == k ? 1e-9 : 0.0;
        for (int j = 0; j < joints; ++j) seen[i][k] += state.jacobian[i][j] * columns[k][j];
      }
    }
    if (!solve_positive(seen, felt)) return;
    for (int j = 0; j < joints; ++j) {
      torque[j] += posture[j];
      for (int i = 0; i < 6; ++i) torque[j] -= state.jacobian[i][j] * felt[i];
    }
  }

  static bool solve_mass(const ArmState<joints>& state, double (&b)[joints]) noexcept {
    double mass[joints][joints];
    for (int j = 0; j < joints; ++j) std::copy_n(state.mass[j], joints, mass[j]);
    return solve_positive(mass, b);
  }

  void limit(const double* torque, Command& command) noexcept {
    const double step = valid_ ? settings_.most_torque_rate * settings_.period : 0.0;
    for (int j = 0; j < joints; ++j) {
      const double most = settings_.most_torque[j], wanted = command.stopped ? 0.0 : torque[j];
      const double inside = valid_ ? std::min(most, std::max(-most, wanted)) : 0.0;
      last_[j] = valid_ ? std::min(last_[j] + step, std::max(last_[j] - step, inside)) : 0.0;
      command.torque[j] = last_[j];
      command.limited = command.limited || command.torque[j] != wanted;
    }
  }

  Settings settings_;
  bool valid_ = false;
  double last_[joints] = {};  // torques of the last call
};

}  // namespace s2nnds
