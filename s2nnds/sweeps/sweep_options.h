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
  std::string key = "training.rounds";
  std::vector<std::int64_t> budgets;
  double keep = 1.0 / 3.0;

  void visit(FieldVisitor& v);
};

// One trial of the design "list".
struct ListedTrial {
  std::string config;  // the name that one of the sweep's configurations gives itself
  std::int64_t seed = 0;
  std::string profile = {};             // empty: the configuration's
  std::vector<std::int64_t> test = {};  // test demonstrations; empty: the configuration's
  std::vector<std::string> set = {};    // key=value, before the sweep's own `set`

  void visit(FieldVisitor& v);
};

// A sweep's file, but for its table `axes` (axis.h). A point is one choice of values for all axes; it is
// tried on every configuration with every seed, and is as good as those runs together. Not crossed: on one of
// these pairs, so that as many runs show what each axis does (effects.h) rather than how good few points are.
struct SweepOptions {
  std::string name = "sweep";
  std::vector<std::string> configs;  // relative to the sweep's file
  std::vector<std::int64_t> seeds = {0};
  std::vector<std::string> set;  // key=value, for every trial

  std::string design = "grid";      // grid, random, sobol, list
  std::int64_t points = 0;          // of random and sobol
  std::int64_t design_seed = 0;     // of random; shifts sobol's points unless 0
  std::vector<ListedTrial> trials;  // of a list, which has no axes: each trial is a point, tried once
  bool crossed = true;              // else the points take the pairs of configuration and seed in turn, each
                                    // time through in another random order

  // What the summary of a run calls it. Figures of test demonstrations are not among the choices.
  std::string objective = "mse_train";
  std::string direction = "minimize";
  std::string guarantee = "none";  // the least guarantee that counts
  double dtw_limit = 0.0;  // the most a run's dtw_train may be to count: a certificate can be of a motion
                           // that passes the obstacle on the other side than the demonstrations; 0: any
  double share = 1.0;      // of a point's runs that must count

  std::int64_t threads = 1;  // a trial
  std::int64_t retries = 2;  // of a trial whose process was killed; it goes on from its last round
  HalvingOptions halving;

  void visit(FieldVisitor& v);
  std::int64_t rungs() const {
    return halving.budgets.empty() ? 1 : static_cast<std::int64_t>(halving.budgets.size());
  }
};

// Reads all but the axes. Throws Error as read_toml does, and on what does not fit together.
SweepOptions read_sweep_options(const std::string& text, const std::string& source);

}  // namespace s2nnds
