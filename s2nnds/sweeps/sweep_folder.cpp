// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/sweep_folder.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/settings.h"

namespace s2nnds {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t runs_a_folder = 1000;

std::string stem(std::int64_t trial) { return fmt::format("runs/{:04}/{:07}", trial / runs_a_folder, trial); }

std::string read_whole(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void make_folders(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  check(!error, "{}: cannot make the folder: {}", path, error.message());
}

// The sweep's file with the configurations' frozen names.
std::string frozen_text(const Sweep& sweep) {
  std::string names;
  for (const BaseConfig& base : sweep.configs) {
    names += fmt::format("{}\"configs/{}.toml\"", names.empty() ? "" : ", ", base.name);
  }
  return with_settings(sweep.text, "the sweep", {fmt::format("configs=[{}]", names)});
}

// Random and Sobol designs begin with the points of a smaller one, and without halving their trials have the
// same numbers. Not if some are conformal: their beta was split over fewer.
bool is_larger(const Sweep& sweep, const std::string& text, const std::string& there,
               const std::string& path) {
  const auto without_points = [&](const std::string& a) { return with_settings(a, path, {"points=0"}); };
  return sweep.options.design != "grid" && sweep.options.rungs() == 1 && !sweep.is_conformal &&
         without_points(there) == without_points(text) &&
         read_sweep_options(there, path).points <= sweep.options.points;
}

}  // namespace

std::string SweepFolder::run_name(std::int64_t trial) { return stem(trial) + ".h5"; }
std::string SweepFolder::result(std::int64_t trial) const { return file(stem(trial) + ".json"); }
std::string SweepFolder::log(std::int64_t trial) const { return file(stem(trial) + ".log"); }

void SweepFolder::make_run_folder(std::int64_t trial) const {
  make_folders(file(fmt::format("runs/{:04}", trial / runs_a_folder)));
}

void SweepFolder::freeze(const Sweep& sweep) const {
  std::vector<std::pair<std::string, std::string>> files;  // path, text
  for (const BaseConfig& base : sweep.configs) files.emplace_back(config(base), base.text);
  files.emplace_back(sweep_file(), frozen_text(sweep));  // last: where it is, the others are
  for (const auto& [path, text] : files) {
    if (!fs::exists(path)) continue;
    const std::string there = read_whole(path);
    check(there == text || (path == sweep_file() && is_larger(sweep, text, there, path)),
          "{}: found another sweep in the folder {}; expected the same one to go on with, or the same with "
          "more points (or choose another --out)",
          path, path_);
  }
  make_folders(file("configs"));
  for (const auto& [path, text] : files) write_atomic_file(path, text, "the sweep");
}

}  // namespace s2nnds
