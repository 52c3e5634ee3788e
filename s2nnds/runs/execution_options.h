// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/conditions/execution_model.h"
#include "s2nnds/core/options.h"
#include "s2nnds/data/frame.h"

namespace s2nnds {

// How the robot executes the motion, for the proof to cover it (conditions/execution_model.h). All zeros:
// only the ideal motion x' = f(x) is certified.
struct ExecutionOptions {
  // Where the other keys start from: none, or arm_1khz, an arm at 1 kHz with feed-forward: 1 ms period, 1 ms
  // delay, positions wrong by 1 mm, velocities by 2 % and 1 mm/s.
  std::string preset = "none";
  // Of the two lengths and velocities below: data (that of the demonstrations), mm, m, or normalised.
  std::string unit = "data";
  double period = 0.0;  // s: the longest time between two readings, >= 0
  double delay = 0.0;   // s: the oldest that a reading can be when its command begins, >= 0
  double lag = 0.0;     // s: mass over damping of an arm that tracks velocities without feed-forward, >= 0
  double position_error = 0.0;           // in `unit`: of a reading, at most, >= 0
  double velocity_error = 0.0;           // in `unit` a second: of the arm's velocity, at most, >= 0
  double velocity_error_relative = 0.0;  // the same as a share of the commanded velocity, in [0, 1)
  double speed = 1.0;                    // factor on f with which the motion is executed, > 0
  // In `unit`: what the demonstrations' largest coordinate (1 normalised) is where the robot moves on another
  // scale than they were recorded on, >= 0; 0: on the same. Times stay; the other lengths and velocities are
  // the robot's.
  double extent = 0.0;
  // N s/m, >= 0: damping of an arm that tracks velocities, for which the largest push that it withstands is
  // told; 0: none is.
  double damping = 0.0;
  // In `unit`, >= 0: training asks for V to fall as executed where the goal is farther than this; 0: nowhere.
  // What ball the motion converges to is proved and told in any case.
  double convergence_radius = 0.0;

  void visit(FieldVisitor& v);  // names each field once; a preset that is read sets all others

  bool is_ideal() const;  // nothing is asked for: every error and time is 0 and the speed 1
};

// The model in normalised units; `field_error` bounds the error of evaluating f (normalised velocity). Throws
// Error where `unit` cannot be told from the data's.
ExecutionModel execution_model(const ExecutionOptions& options, const Frame& frame, double field_error);

// What training asks of the conditions; all but field_error, which depends on f.
ExecutionDemand execution_demand(const ExecutionOptions& options, const Frame& frame);

// Metres that 1 normalised is where the robot moves. Throws Error where the data's unit is no length.
double metres_per_normalised(const ExecutionOptions& options, const Frame& frame);

// The model in words, in the data's unit, lengths as the robot moves: "a reading every 1 ms or sooner, at
// most 1 ms old and wrong by at most ...".
std::string execution_in_words(const ExecutionOptions& options, const Frame& frame);

}  // namespace s2nnds
