// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "s2nnds/evaluation/state_function.h"
#include "s2nnds/problem/safety_problem.h"

namespace s2nnds {

// Why a motion is not followed further.
enum class StopReason {
  reached_goal,    // within goal_radius of the goal
  entered_unsafe,  // touched Xu
  left_workspace,  // left X, or entered the workspace margin
  time_out,        // none of these within the duration
  // A step could not be made, or there were too many.
  step_failed
};
// The name of the enumerator.
std::string_view to_string(StopReason reason);

// How one motion is followed.
struct RolloutOptions {
  double goal_radius = 0.02;         // normalised, > 0: reached_goal inside it
  double duration = 60.0;            // longest normalised time, > 0
  double absolute_tolerance = 1e-6;  // of the position in a step, normalised, > 0
  double relative_tolerance = 1e-6;  // of the position in a step, as a share of it, > 0
  bool stop_at_goal = true;          // the motion ends at the goal
  bool stop_at_unsafe = true;        // and at Xu, at the workspace's edge and at its margin

  void visit(FieldVisitor& v);  // names every key and its range
};

// One motion of xdot = f(x), in normalised units.
struct Rollout {
  Vector time;                             // [M], ascending from 0
  Points position;                         // [M, n], at these times
  StopReason stop = StopReason::time_out;  // what happened at the last point
};

// Integrates with an adaptive Runge-Kutta method (Dormand-Prince 5(4), Boost.Odeint). The motion is followed
// on the dense output in sub-steps of at most 0.005 of length, so that a set is noticed if the motion stays
// in it that long (a single step longer than 5 is looked at 1,024 times); the moment of entry is bisected.
// After 50,000 steps the motion counts as failed. Leaving the workspace includes entering the workspace
// margin. The last point is where the motion stopped. Throws Error unless f maps n -> n.
Rollout roll_out(const StateFunction& f, const SafetyProblem& problem, const Vector& start,
                 const RolloutOptions& options = {});

// The position at each of `times` (ascending, normalised, from 0): [M, n]; never stops early. Rows after a
// failed step (the motion escapes to infinity) are NaN.
Points roll_out_at(const StateFunction& f, const Vector& start, const Vector& times,
                   const RolloutOptions& options = {});

// How rollout_is_safe() follows motions.
struct BatchRolloutOptions {
  double step = 0.5;        // longest step, normalised time, > 0
  double tolerance = 3e-4;  // largest local error of a step, normalised position, > 0
  // Longest normalised time, > 0; not at the goal by then, or after 2,000 steps, counts as unsafe.
  double duration = 40.0;
  double goal_radius = 0.02;  // normalised, > 0: a motion that comes so near to the goal has reached it
};
// For many starts [N, n] at once, labels [N]: true where the rollout reaches the goal without touching the
// unsafe set or leaving the workspace (or entering the workspace margin). All points advance together by
// Bogacki-Shampine 3(2) (Bogacki, Shampine 1989), each with a step of its own; sets are looked for every
// 0.005 of length, as in roll_out. Takes f.quick_value. For training labels and areas, not proofs.
std::vector<bool> rollout_is_safe(const StateFunction& f, const SafetyProblem& problem, const Points& starts,
                                  const BatchRolloutOptions& options = {});

}  // namespace s2nnds
