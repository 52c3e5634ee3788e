// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/sweep_options.h"

#include <algorithm>
#include <set>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

struct NoKeys {
  void visit(FieldVisitor&) {}
};

template <typename T>
void check_different(const std::string& source, const char* key, const std::vector<T>& values) {
  check(!values.empty(), "{}: {}: expected at least one, found none", source, key);
  std::set<T> seen;
  for (const T& value : values) {
    check(seen.insert(value).second, "{}: {}: found {} twice; expected different ones", source, key, value);
  }
}

}  // namespace

void HalvingOptions::visit(FieldVisitor& v) {
  v.field("key", key);
  v.field("budgets", budgets, at_least(1));
  v.field("keep", keep, inside(0.0, 1.0));
}

void ListedTrial::visit(FieldVisitor& v) {
  v.field("config", config);
  v.field("seed", seed, at_least(0));
  v.field("profile", profile);
  v.field("test", test, at_least(0));
  v.field("set", set);
}

void SweepOptions::visit(FieldVisitor& v) {
  v.field("name", name);
  v.field("configs", configs);
  v.field("seeds", seeds, at_least(0));
  v.field("set", set);
  v.field("design", design, {"grid", "random", "sobol", "list"});
  v.field("points", points, between(0, 1'000'000));
  v.field("design_seed", design_seed, at_least(0));
  v.list("trials", trials);
  v.field("crossed", crossed);
  v.field("objective", objective,
          {"mse_train", "mse_validation", "sd_train", "dtw_train", "safe_area", "safe_area_ratio",
           "disturbance_margin", "convergence_radius", "rounds", "seconds"});
  v.field("direction", direction, {"minimize", "maximize"});
  v.field("guarantee", guarantee, {"none", "sampled", "conformal", "proved", "invariant"});
  v.field("dtw_limit", dtw_limit, at_least(0.0));
  v.field("share", share, between(0.0, 1.0));
  v.field("threads", threads, at_least(1));
  v.field("retries", retries, between(0, 100));
  v.group("halving", halving);
  NoKeys axes;  // read elsewhere; named here so that the key is known
  v.group("axes", axes);
}

SweepOptions read_sweep_options(const std::string& text, const std::string& source) {
  SweepOptions options;
  read_toml(text, source, options, {"axes={}"});
  check_different(source, "configs", options.configs);
  check_different(source, "seeds", options.seeds);
  const bool drawn = options.design == "random" || options.design == "sobol";
  check(drawn == (options.points >= 1), "{}: points: expected {} for the design {}, found {}", source,
        drawn ? "at least 1" : "none", options.design, options.points);
  const bool listed = options.design == "list";
  check(listed == !options.trials.empty(), "{}: trials: expected {} for the design {}, found {}", source,
        listed ? "at least one" : "none", options.design, options.trials.size());
  if (listed) options.crossed = false;
  const auto& budgets = options.halving.budgets;
  check(std::is_sorted(budgets.begin(), budgets.end(), std::less_equal<>()),
        "{}: halving.budgets: expected each above the one before", source);
  check(options.crossed || budgets.empty(),
        "{}: halving: it compares points, which needs crossed = true and no list", source);
  check(!options.name.empty() && options.name.find_first_of("/\n") == std::string::npos,
        "{}: name: expected a file's name, found \"{}\"", source, options.name);
  return options;
}

}  // namespace s2nnds
