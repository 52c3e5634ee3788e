// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "s2nnds/data/phase.h"
#include "s2nnds/data/survey.h"
#include "s2nnds/problem/clearance.h"
#include "s2nnds/runs/config.h"
#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

// What a configuration asks for, looked at before any training; whatever is wrong with it is in words, so that
// what there is can be told and drawn.
struct Scene {
  Config config;
  DemonstrationSet data;  // as read and cleaned
  Survey survey;
  PhaseChoice phase;                  // whether a phase is added to the positions
  std::optional<Frame> frame;         // none: the goal is refused
  std::vector<Demonstration> states;  // [K] of `data`, with the phase where there is one; empty without frame
  std::optional<SafetyProblem> problem;  // normalised; none: a set cannot be made at all
  std::vector<Clearance> clearances;     // [K] in the data's unit and frame; empty without problem
  std::vector<std::string> refusals;     // why training would refuse it
  std::vector<std::string> warnings;     // what training would not refuse, but a motion x' = f(x) cannot do
};

// Reads the data and builds what can be built. Throws Error where the data cannot be read at all.
Scene look_at(const Config& config, const std::string& data_dir, const ReadingProgress& progress = {});

// What x' = f(x) cannot follow in demonstrations as read: closed ones, crossings, pauses; with a phase, pauses alone.
std::vector<std::string> warnings_of(const Survey& survey, const std::string& unit, bool has_phase = false);

// Why no motion can be safe from all of the initial set and the demonstrations' starts, in words; empty where the obstacle
// cuts nothing off from the goal, as far as a grid shows (find_reachability).
std::vector<std::string> impossibilities(const SafetyProblem& problem, const Frame& frame,
                                         const std::vector<Demonstration>& normalised);

// Which demonstrations start together and pass the obstacle on different sides, in words (find_passing_sides).
std::optional<std::string> sides_warning(const SafetyProblem& problem, const Frame& frame,
                                         const std::vector<Demonstration>& normalised);

// That a proof is asked for which is unlikely to end: in over four dimensions, or in four with profile robust; else "".
std::string dimension_warning(Config config, Eigen::Index dimension);

// How far each demonstration, in normalised units, stays from the obstacle within the workspace; the result is
// in the data's unit and frame, to a thousandth of the largest coordinate. Empty where there is no obstacle.
std::vector<Clearance> clearances_of(const SafetyProblem& problem, const ProblemOptions& options,
                                     const std::vector<Demonstration>& normalised, const Frame& frame);

// "0: 0.12 m, 1: passes through it (12 of 400 places, first at (0.3, 0.2) m)"; one text a demonstration.
std::vector<std::string> clearance_texts(const std::vector<Clearance>& clearances, const Frame& frame);

// "(0.3, 0.2) m", to some four digits of `extent`.
std::string place_text(const Vector& place, double extent, const std::string& unit);

// Writes what figures are made of (module plot_scene). Throws Error as Hdf5Writer does.
void save_scene(const std::string& path, const Scene& scene);

}  // namespace s2nnds
