// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

namespace s2nnds {

// How a robot executes xdot = f(x), in normalised length and time. Every `period` or sooner it takes a
// reading y of a position that is at most `delay` old, with |y - x| <= position_error, and commands u = speed
// (f(y) + e), |e| <= field_error, until the next. It moves with xdot = v + w, |w| <= velocity_error +
// velocity_error_relative |u|, where v = u, or, with lag > 0, lag vdot = u - v, v(0) being the first command.
// Before the start it is where it starts.
struct ExecutionModel {
  double period = 0.0, delay = 0.0, lag = 0.0;                 // >= 0
  double position_error = 0.0;                                 // >= 0
  double velocity_error = 0.0, velocity_error_relative = 0.0;  // >= 0
  double field_error = 0.0;                                    // >= 0: of evaluating f
  double least_speed = 1.0, most_speed = 1.0;                  // of the factor on f; 0 < least <= most

  double window() const { return period + delay; }  // a command is at most this old
  // Whether f is evaluated elsewhere than where the robot is.
  bool displaces() const { return window() + lag + position_error > 0.0; }
  // Whether it moves with f exactly, but for the factor.
  bool is_ideal() const {
    return !displaces() && !(velocity_error + velocity_error_relative + field_error > 0.0);
  }
};

// What the conditions ask for beyond xdot = f(x).
struct ExecutionDemand {
  ExecutionModel model;  // Bdot < 0 as executed, and
  // Vdot < 0 as executed where |x|_2 > this, > 0: the model's errors do not vanish at the goal.
  double convergence_radius = std::numeric_limits<double>::infinity();

  bool asks_of_barrier() const { return !model.is_ideal(); }
  bool asks_of_lyapunov() const {
    return !model.is_ideal() && convergence_radius < std::numeric_limits<double>::infinity();
  }
};

}  // namespace s2nnds
