#include "s2nnds/sweeps/sweep.h"

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

Config with_settings(const BaseConfig& base, const std::vector<std::string>& settings) {
  return parse_config(with_overrides(base.text, base.path, settings), base.path);
}

BaseConfig read_base(const std::string& sweep_path, const std::string& config) {
  BaseConfig base;
  base.path = (fs::path(sweep_path).parent_path() / config).string();
  base.text = read_config_text(base.path, {});
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

// One axis at a time: trying all combinations would take as long as the sweep has trials.
void check_axes(const Sweep& sweep, const std::string& path) {
  for (const BaseConfig& base : sweep.configs) {
    for (const Axis& axis : sweep.axes) {
      for (const std::string& value : axis.extremes()) {
        std::vector<std::string> settings = sweep.options.set;
        for (const std::string& setting : settings_of(axis, value)) settings.push_back(setting);
        try {
          with_settings(base, settings);
        } catch (const Error& error) {
          fail("{}:{}: axes: {} = {}: {}", path, axis.line, axis.key, value, error.what());
        }
      }
    }
  }
}

void check_bases(const Sweep& sweep, const std::string& path) {
  for (const BaseConfig& base : sweep.configs) {
    std::vector<std::string> settings = sweep.options.set;
    if (sweep.options.rungs() > 1) {
      settings.push_back(fmt::format("{}={}", sweep.options.halving.key, sweep.options.halving.budgets[0]));
    }
    try {
      const Config config = with_settings(base, settings);
      check(sweep.options.objective != "mse_validation" || !config.data.validation.empty(),
            "objective mse_validation: expected demonstrations in data.validation, found none");
    } catch (const Error& error) {
      fail("{}: {}: {}", path, base.path, error.what());
    }
  }
}

}  // namespace

std::int64_t Sweep::trials_a_point() const {
  return pairs.empty() ? static_cast<std::int64_t>(configs.size() * options.seeds.size()) : 1;
}

std::int64_t Sweep::trials_a_rung() const {
  return static_cast<std::int64_t>(points.size()) * trials_a_point();
}

std::int64_t Sweep::id_of(std::int64_t rung, std::int64_t point) const {
  return rung * trials_a_rung() + point * trials_a_point();
}

Trial Sweep::trial(std::int64_t id) const {
  const std::int64_t all = trials_a_rung() * options.rungs();
  check(id >= 0 && id < all, "trial: found {}, expected 0 to {}", id, all - 1);
  const auto seeds = static_cast<std::int64_t>(options.seeds.size());
  Trial trial;
  trial.id = id;
  trial.rung = id / trials_a_rung();
  trial.point = id % trials_a_rung() / trials_a_point();
  const std::int64_t pair = pairs.empty() ? id % trials_a_point() : pairs[trial.point];
  trial.config = pair / seeds;
  trial.seed = pair % seeds;
  return trial;
}

std::vector<std::string> Sweep::settings(const Trial& trial) const {
  std::vector<std::string> all = options.set;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    for (const std::string& setting : settings_of(axes[k], points[trial.point][k])) all.push_back(setting);
  }
  if (options.rungs() > 1) {
    all.push_back(fmt::format("{}={}", options.halving.key, options.halving.budgets[trial.rung]));
  }
  all.push_back(fmt::format("seed={}", options.seeds[trial.seed]));
  return all;
}

Sweep read_sweep(const std::string& path) {
  Sweep sweep;
  sweep.text = read_text(path);
  sweep.options = read_sweep_options(sweep.text, path);
  sweep.axes = read_axes(sweep.text, path);
  std::set<std::string> names;
  for (const std::string& config : sweep.options.configs) {
    sweep.configs.push_back(read_base(path, config));
    check(names.insert(sweep.configs.back().name).second,
          "{}: configs: found two of the name {}; expected different names", path, sweep.configs.back().name);
  }
  check_keys(sweep, path);
  check_bases(sweep, path);
  check_axes(sweep, path);
  sweep.points = make_design(sweep.options, sweep.axes);
  if (!sweep.options.crossed) {
    sweep.pairs = pairs_in_turn(sweep.points.size(), sweep.configs.size() * sweep.options.seeds.size(),
                                sweep.options.design_seed);
  }
  return sweep;
}

}  // namespace s2nnds
