// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/sweep.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "s2nnds/core/check.h"
#include "s2nnds/runs/config.h"

namespace s2nnds {
namespace {

namespace fs = std::filesystem;

std::string read_text(const std::string& path) {
  std::ifstream file(path);
  check(file.good() && !fs::is_directory(path), "{}: cannot read it; expected a sweep's file (TOML)", path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// Throws Error when the settings, of which `what` says where they come from, do not fit the configuration.
Config try_settings(const BaseConfig& base, const std::vector<std::string>& settings,
                    const std::string& what) {
  try {
    return parse_config(base.text, base.path, settings);
  } catch (const Error& error) {
    fail("{}: {}", what, error.what());
  }
}

BaseConfig read_base(const std::string& folder, const std::string& config) {
  BaseConfig base;
  base.path = (fs::path(folder) / config).string();
  base.text = read_config_text(base.path);
  base.name = parse_config(base.text, base.path).name;
  check(!base.name.empty() && base.name.find_first_of("/\n") == std::string::npos && base.name[0] != '.',
        "{}: name: expected a file's name, found \"{}\"", base.path, base.name);
  return base;
}

void check_keys(const Sweep& sweep, const std::string& path) {
  std::set<std::string> seen = {"seed", "name"};  // seeds has an entry of its own, names come from configs
  if (sweep.options.rungs() > 1) seen.insert(sweep.options.halving.key);
  for (const Axis& axis : sweep.axes) {
    std::vector<std::string> keys = axis.also;
    keys.push_back(axis.key);
    for (const std::string& key : keys) {
      check(seen.insert(key).second, "{}:{}: axes: {}: the sweep sets this key elsewhere already", path,
            axis.line, key);
    }
  }
}

std::vector<std::string> settings_of(const Axis& axis, const std::string& value) {
  std::vector<std::string> settings = {axis.key + "=" + value};
  for (const std::string& key : axis.also) settings.push_back(key + "=" + value);
  return settings;
}

// One axis at a time: trying all combinations would take as long as the sweep has trials. Returns whether some of them
// ends with conformal verification.
bool check_settings(const Sweep& sweep, const std::string& path) {
  bool is_conformal = false;
  for (const BaseConfig& base : sweep.configs) {
    std::vector<std::string> settings = sweep.options.set;
    if (sweep.options.rungs() > 1)
      settings.push_back(fmt::format("{}={}", sweep.options.halving.key, sweep.options.halving.budgets[0]));
    const Config config = try_settings(base, settings, path + ": " + base.path);
    is_conformal |= config.verification.method == Method::conformal;
    check(sweep.options.objective != "mse_validation" || !config.data.validation.empty(),
          "{}: {}: objective mse_validation: expected demonstrations in data.validation, found none", path,
          base.path);
    for (const Axis& axis : sweep.axes) {
      for (const std::string& value : axis.extremes()) {
        settings = sweep.options.set;
        for (const std::string& setting : settings_of(axis, value)) settings.push_back(setting);
        const Config tried = try_settings(
            base, settings, fmt::format("{}:{}: axes: {} = {}", path, axis.line, axis.key, value));
        is_conformal |= tried.verification.method == Method::conformal;
      }
    }
  }
  return is_conformal;
}

std::int64_t config_named(const Sweep& sweep, const std::string& name) {
  const auto found = std::find_if(sweep.configs.begin(), sweep.configs.end(),
                                  [&](const BaseConfig& base) { return base.name == name; });
  check(found != sweep.configs.end(), "{}: trials: found no configuration of the name \"{}\"",
        sweep.options.name, name);
  return found - sweep.configs.begin();
}

bool check_list(const Sweep& sweep, const std::string& path) {
  bool is_conformal = false;
  check(sweep.axes.empty(), "{}: axes: expected none for the design list, found {}", path, sweep.axes.size());
  for (std::int64_t id = 0; id < sweep.trials_a_rung(); ++id) {
    const Trial trial = sweep.trial(id);
    const Config tried = try_settings(sweep.configs[trial.config], sweep.settings(trial),
                                      fmt::format("{}: trial {}", path, id));
    is_conformal |= tried.verification.method == Method::conformal;
  }
  return is_conformal;
}

}  // namespace

std::int64_t Sweep::trials_a_point() const {
  return options.crossed ? static_cast<std::int64_t>(configs.size() * options.seeds.size()) : 1;
}

std::int64_t Sweep::trials_a_rung() const {
  return static_cast<std::int64_t>(points.size()) * trials_a_point();
}

std::int64_t Sweep::trials() const { return trials_a_rung() * options.rungs(); }

std::int64_t Sweep::id_of(std::int64_t rung, std::int64_t point) const {
  return rung * trials_a_rung() + point * trials_a_point();
}

Trial Sweep::trial(std::int64_t id) const {
  check(id >= 0 && id < trials(), "trial: found {}, expected 0 to {}", id, trials() - 1);
  const auto seeds = static_cast<std::int64_t>(options.seeds.size());
  Trial trial;
  trial.id = id;
  trial.rung = id / trials_a_rung();
  trial.point = id % trials_a_rung() / trials_a_point();
  if (!options.trials.empty()) {
    const ListedTrial& listed = options.trials[trial.point];
    trial.config = config_named(*this, listed.config);
    trial.seed = listed.seed;
    trial.profile = listed.profile;
    trial.test = listed.test;
    return trial;
  }
  const std::int64_t pair = pairs.empty() ? id % trials_a_point() : pairs[trial.point];
  trial.config = pair / seeds;
  trial.seed = options.seeds[pair % seeds];
  return trial;
}

std::string Sweep::label(const Trial& trial) const {
  std::string label = configs[trial.config].name;
  if (!trial.test.empty()) label += fmt::format("-test{}", fmt::join(trial.test, "_"));
  label += fmt::format("-seed{}", trial.seed);
  return trial.profile.empty() ? label : label + "-" + trial.profile;
}

std::vector<std::string> Sweep::settings(const Trial& trial) const {
  std::vector<std::string> all;
  if (!trial.profile.empty()) all.push_back(fmt::format("profile=\"{}\"", trial.profile));
  if (!trial.test.empty()) all.push_back(fmt::format("data.test=[{}]", fmt::join(trial.test, ", ")));
  const auto add = [&all](const std::vector<std::string>& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  if (!options.trials.empty()) add(options.trials[trial.point].set);
  add(options.set);
  for (std::size_t k = 0; k < axes.size(); ++k) {
    add(settings_of(axes[k], points[trial.point][k]));
  }
  if (options.rungs() > 1) {
    all.push_back(fmt::format("{}={}", options.halving.key, options.halving.budgets[trial.rung]));
  }
  all.push_back(fmt::format("seed={}", trial.seed));
  if (!is_conformal) return all;
  const BaseConfig& base = configs[trial.config];
  const VerificationOptions verification = parse_config(base.text, base.path, all).verification;
  if (verification.method == Method::conformal)
    all.push_back(fmt::format("verification.conformal.beta={}",
                              verification.conformal.beta / static_cast<double>(trials())));
  return all;
}

Sweep read_sweep(const std::string& path) {
  return parse_sweep(read_text(path), path, fs::path(path).parent_path());
}

Sweep parse_sweep(const std::string& text, const std::string& path, const std::string& folder) {
  Sweep sweep;
  sweep.text = text;
  sweep.options = read_sweep_options(text, path);
  sweep.axes = read_axes(text, path);
  std::set<std::string> names;
  for (const std::string& config : sweep.options.configs) {
    sweep.configs.push_back(read_base(folder, config));
    check(names.insert(sweep.configs.back().name).second,
          "{}: configs: found two of the name {}; expected different names", path, sweep.configs.back().name);
  }
  check_keys(sweep, path);
  bool is_conformal = check_settings(sweep, path);
  sweep.points = make_design(sweep.options, sweep.axes);
  if (!sweep.options.trials.empty()) {
    is_conformal |= check_list(sweep, path);
  } else if (!sweep.options.crossed) {
    sweep.pairs = pairs_in_turn(sweep.points.size(), sweep.configs.size() * sweep.options.seeds.size(),
                                sweep.options.design_seed);
  }
  sweep.is_conformal = is_conformal;
  return sweep;
}

}  // namespace s2nnds
