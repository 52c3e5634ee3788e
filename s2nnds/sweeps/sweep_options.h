// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/core/options.h"

namespace s2nnds {

// Successive halving (Jamieson, Talwalkar 2016): every point gets the first budget, the best share `keep` of
// them the next one, and so on. Empty budgets: off.
struct HalvingOptions {
  std::string key = "training.rounds";  // dotted key that takes the budget
  std::vector<std::int64_t> budgets;    // of each rung, >= 1, each above the one before
  double keep = 1.0 / 3.0;              // share of a rung's points that goes on, in (0, 1), rounded up

  void visit(FieldVisitor& v);  // names each field once
};

// One trial of the design "list".
struct ListedTrial {
  std::string config;                   // the name that one of the sweep's configurations gives itself
  std::int64_t seed = 0;                // of the run, >= 0
  std::string profile = {};             // empty: the configuration's
  std::vector<std::int64_t> test = {};  // test demonstrations; empty: the configuration's
  std::vector<std::string> set = {};    // key=value, before the sweep's own `set`

  void visit(FieldVisitor& v);  // names each field once
};

// A sweep's file, but for its table `axes` (axis.h). A point is one choice of values for all axes; it is
// tried on every configuration with every seed, and is as good as those runs together. Not crossed: on one of
// these pairs, so that as many runs show what each axis does (effects.h) rather than how good few points are.
struct SweepOptions {
  std::string name = "sweep";        // of the sweep, for messages and reports
  std::vector<std::string> configs;  // files of configurations, relative to the sweep's file; at least one
  std::vector<std::int64_t> seeds = {0};  // of the runs, >= 0, all different; at least one
  std::vector<std::string> set;           // key=value, for every trial

  std::string design = "grid";      // how points are chosen: grid, random, sobol, list (make_design)
  std::int64_t points = 0;          // how many, of random and sobol: 1 to 1,000,000; 0 of the others
  std::int64_t design_seed = 0;     // of random, >= 0; shifts sobol's points unless 0
  std::vector<ListedTrial> trials;  // of a list, which has no axes: each trial is a point, tried once
  // Every point is tried on every pair of configuration and seed; else the points take the pairs in turn,
  // each time through in another random order.
  bool crossed = true;

  // The figure by which points are ranked, as the summary of a run calls it: mse_train, mse_validation,
  // sd_train, dtw_train, safe_area, safe_area_ratio, disturbance_margin, convergence_radius, rounds or
  // seconds. Figures of test demonstrations are not among the choices.
  std::string objective = "mse_train";
  std::string direction = "minimize";  // of the objective: minimize, maximize
  std::string guarantee = "none";      // the least guarantee that counts
  // The most a run's dtw_train may be to count, >= 0, normalised length: a certificate can be of a motion
  // that passes the obstacle on the other side than the demonstrations; 0: any.
  double dtw_limit = 0.0;
  double share = 1.0;  // of a point's runs that must count, in [0, 1]

  std::int64_t threads = 1;  // of a trial, >= 1
  std::int64_t retries = 2;  // of a trial whose process was killed, 0 to 100; it goes on from its last round
  HalvingOptions halving;    // longer runs for the better points only

  void visit(FieldVisitor& v);  // names each field once
  // Rungs of successive halving: the budgets, or 1 when it is off.
  std::int64_t rungs() const {
    return halving.budgets.empty() ? 1 : static_cast<std::int64_t>(halving.budgets.size());
  }
};

// Reads all but the axes. Throws Error as read_toml does, and on what does not fit together.
SweepOptions read_sweep_options(const std::string& text, const std::string& source);

}  // namespace s2nnds
