// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "s2nnds/evaluation/state_function.h"
#include "s2nnds/problem/safety_problem.h"

namespace s2nnds {

enum class StopReason { reached_goal, entered_unsafe, left_workspace, time_out, step_failed };
std::string_view to_string(StopReason reason);

struct RolloutOptions {
  double goal_radius = 0.02;  // normalised; reached_goal inside it
  double duration = 60.0;     // longest normalised time
  double absolute_tolerance = 1e-6;
  double relative_tolerance = 1e-6;
  bool stop_at_goal = true;
  bool stop_at_unsafe = true;  // and at the workspace's edge

  void visit(FieldVisitor& v);
};

// One motion of xdot = f(x), in normalised units.
struct Rollout {
  Vector time;      // [M]
  Points position;  // [M, n]
  StopReason stop = StopReason::time_out;
};

// Integrates with an adaptive Runge-Kutta method (Dormand-Prince 5(4), Boost.Odeint). The motion is followed
// on the dense output in sub-steps of at most 0.005 of length, so that a set is noticed if the motion stays
// in it that long (a single step longer than 5 is looked at 1,024 times); the moment of entry is bisected.
// After 50,000 steps the motion counts as failed. Leaving the workspace includes entering the workspace margin. The last
// point is where the motion stopped. Throws Error unless f maps n -> n.
Rollout roll_out(const StateFunction& f, const SafetyProblem& problem, const Vector& start,
                 const RolloutOptions& options = {});

// The position at each of `times` (ascending, normalised, from 0): [M, n]; never stops early. Rows after a
// failed step (the motion escapes to infinity) are NaN.
Points roll_out_at(const StateFunction& f, const Vector& start, const Vector& times,
                   const RolloutOptions& options = {});

// For many starts [N, n] at once, labels [N]: true where the rollout reaches the goal without touching the unsafe set or
// leaving the workspace (or entering the workspace margin). All points advance together by Bogacki-Shampine 3(2)
// (Bogacki, Shampine 1989), each with a step of its own; sets are looked for every 0.005 of length, as in
// roll_out. Takes f.quick_value. For training labels and areas, not proofs.
struct BatchRolloutOptions {
  double step = 0.5;        // longest step, normalised time
  double tolerance = 3e-4;  // largest local error of a step, normalised position
  // Longest normalised time; not at the goal by then, or after 2,000 steps, counts as unsafe.
  double duration = 40.0;
  double goal_radius = 0.02;
};
std::vector<bool> rollout_is_safe(const StateFunction& f, const SafetyProblem& problem, const Points& starts,
                                  const BatchRolloutOptions& options = {});

}  // namespace s2nnds
