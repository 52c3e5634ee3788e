// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/data/frame.h"
#include "s2nnds/data/survey.h"

namespace s2nnds {

// A phase s is one more coordinate of the state, behind those of the position x: the part of a demonstration's path
// that is left, as a number that falls from frame.phase_start to 0. Where a motion crosses itself, x' = f(x) has one
// velocity for two branches; (x, s)' = f(x, s) tells them apart.

// Whether the state is to be (x, s), and a line on why; "" where nothing was to be chosen.
struct PhaseChoice {
  bool used = false;
  std::string reason;
};

// What `state` (TableOptions::state) asks for. "auto" uses a phase for a motion in the plane of which at least half of
// the demonstrations cannot be followed without: they end where they start or pass their end on the way (to a
// twentieth of the extent, then a quarter of it away), or come back to another place after they were more than a tenth of
// the extent away from it. `found` is the survey of `set`, of positions.
PhaseChoice choose_phase(const std::string& state, const DemonstrationSet& set, const Survey& found);

// Appends s as the last coordinate of all positions, and s' of all velocities: with v the velocities as they are,
//   s(t) = start (1 - integral of |v| up to t / integral of |v|),  s'(t) = -start |v(t)| / integral of |v|,
// by the trapezoidal rule, in the positions' unit. `start` is the mean length of the paths, so that s runs as fast as x
// moves: of a long path with loops that follow each other closely, a shorter s would turn f, V and B too fast. Returns
// the frame of the states: the goal is (goal, 0), lengths keep their scale, and velocity_scale counts s' too. Throws Error for a demonstration without velocities.
Frame add_phase(DemonstrationSet& set, const Frame& frame);

// Both: the frame of `set` as find_frame(), with a phase where choose_phase() uses one, which becomes a line of the
// set's report.
Frame find_state(DemonstrationSet& set, const std::string& state, const std::string& normalization,
                 const WordOrNumbers& goal);

}  // namespace s2nnds
