// SPDX-License-Identifier: BSD-3-Clause
#include "driver.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <set>

#include "program/local_sweep.h"
#include "program/writable.h"
#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/json_text.h"
#include "s2nnds/core/platform.h"
#include "s2nnds/core/python_module.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/prepared_run.h"
#include "s2nnds/runs/summary.h"
#include "s2nnds/runs/version.h"

namespace s2nnds::experiment {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kHere = S2NNDS_EXPERIMENTS;

void check_seeds(const Arguments& arguments) {
  check(!arguments.seeds.empty(), "--seeds: found none, expected one or more");
  std::set<std::int64_t> seen;
  for (const std::int64_t seed : arguments.seeds)
    check(seen.insert(seed).second, "--seeds: found {} twice, expected each seed once", seed);
  for (const std::string& assignment : arguments.assignments) {
    const std::string key = assignment.substr(0, assignment.find_first_of("= "));
    check(key != "seed", "--set {}: expected --seeds, which all runs of a driver have", assignment);
  }
}

// Fills in what the command line left open and finds out what is wrong with it before hours of training.
void complete(Arguments& arguments, const std::string& name) {
  check_seeds(arguments);
  if (arguments.out.empty()) arguments.out = "runs/" + name + (arguments.quick ? "-quick" : "");
  arguments.data = data_directory(arguments.data);
  const bool standard =
      !arguments.quick && arguments.assignments.empty() && arguments.seeds == Arguments{}.seeds;
  if (arguments.quick) arguments.seeds.resize(1);
  if (arguments.results.empty()) {
    const fs::path folder = standard ? kHere / "results" : fs::path(arguments.out);
    arguments.results = folder / (name + ".json");
    if (!standard) return;  // a folder that is yet to be made
  }
  program::check_writable(arguments.results);
}

Sweep sweep_of(const Driver& driver, const Arguments& arguments) {
  SweepOptions options;
  options.name = driver.name;
  options.configs = driver.configs;
  options.set = arguments.assignments;
  options.design = "list";
  options.trials = driver.trials(arguments);
  options.guarantee = "invariant";
  return parse_sweep(to_toml(options), driver.name, kHere / "configs");
}

// Of one trial a configuration: whether its data are there and its sets fit them.
void check_data(const Sweep& sweep, const Arguments& arguments) {
  std::set<std::int64_t> seen;
  for (std::int64_t id = 0; id < sweep.trials_a_rung(); ++id) {
    const Trial trial = sweep.trial(id);
    if (!seen.insert(trial.config).second) continue;
    const BaseConfig& base = sweep.configs[static_cast<std::size_t>(trial.config)];
    prepare(parse_config(base.text, base.path, sweep.settings(trial)), arguments.data);
  }
}

// Runs what has not ended yet. With --finished nothing, so that trials may be missing.
std::vector<TrialResult> results_of(const Sweep& sweep, const SweepFolder& folder,
                                    const Arguments& arguments) {
  const SweepState state = read_state(sweep, folder);
  if (arguments.finished) return state.results;
  program::forget_failed(folder, state);
  const int cores = available_cores(), jobs = arguments.jobs > 0 ? arguments.jobs : cores;
  const fs::path beside = fs::path(executable_path()).parent_path() / "s2nnds";
  const auto ended =
      program::run_sweep(sweep, folder, {beside, arguments.data, std::max(1, cores / jobs), jobs});
  check(ended.has_value(), "interrupted; the same command goes on");
  return ended->results;
}

std::vector<Run> run_all(const Driver& driver, const Arguments& arguments) {
  const Sweep sweep = sweep_of(driver, arguments);
  const SweepFolder folder(arguments.out);
  check_data(sweep, arguments);
  folder.freeze(sweep);
  std::vector<Run> runs;
  for (const TrialResult& result : results_of(sweep, folder, arguments)) {
    const Trial trial = sweep.trial(result.trial);
    const std::string label = sweep.label(trial), path = folder.run(result.trial);
    check(!result.failed, "{}: {}", label, result.error);
    json summary = json::parse(summary_json(load_certified_run(path), path));
    summary.erase("threads");  // of this process, not of the run's
    runs.push_back({trial, sweep.configs[static_cast<std::size_t>(trial.config)].name, label, path, summary});
  }
  return runs;
}

// Runs one of the Python modules that draw.
void run_plot(const std::string& module, const std::vector<std::string>& words) {
  const int code = run_python_module("figures", module, words);
  check(code == 0, "{}: exit code {}", module, code);
}

// The runs' summaries, each with its trial's label, profile and test demonstrations.
json summaries_of(const std::vector<Run>& runs) {
  json all = json::array();
  for (const Run& run : runs) {
    all.push_back(run.summary);
    all.back().update({{"trial", run.label}, {"profile", run.trial.profile}, {"test", run.trial.test}});
  }
  return all;
}

}  // namespace

int run_driver(int argc, char** argv, const Driver& driver) {
  const std::string& name = driver.name;
  CLI::App app(driver.about, name);
  Arguments arguments;
  bool no_figures = false;
  app.add_option("--data", arguments.data,
                 "folder of the data files (else $S2NNDS_DATA, else ../shared/data)");
  app.add_option("--out", arguments.out, "folder for run files and figures (default: runs/" + name + ")");
  app.add_option("--results", arguments.results,
                 "results file (default: experiments/results/" + name +
                     ".json; with --quick, --set or --seeds in --out)");
  app.add_option("--set", arguments.assignments, "key=value, overrides every run's configuration");
  app.add_option("--seeds", arguments.seeds, "seeds of every problem")->capture_default_str();
  app.add_option("--jobs", arguments.jobs, "runs at a time; 0: one a core")->check(CLI::Range(0, 4096));
  app.add_flag("--quick", arguments.quick, "one seed and one split of every problem");
  app.add_flag("--finished", arguments.finished, "report the runs that have ended, start none");
  app.add_flag("--no-figures", no_figures, "draw nothing");
  try {
    app.parse(argc, argv);
    complete(arguments, name);
    json results = {{"experiment", name},           {"program_version", program_version()},
                    {"created", time_stamp()},      {"seeds", arguments.seeds},
                    {"set", arguments.assignments}, {"quick", arguments.quick}};
    const std::vector<Run> runs = run_all(driver, arguments);
    if (arguments.finished) results["of_runs"] = driver.trials(arguments).size();
    const Report report = driver.report(runs, arguments);
    for (const auto& [title, table] : report.tables) {
      fmt::print("{}{}", results.contains("tables") ? "\n" : "", table.text());
      results["tables"][title] = table.json();
    }
    results["runs"] = summaries_of(runs);
    if (!report.more.is_null()) results.update(report.more);
    write_atomic_file(arguments.results, s2nnds::json_text(results, 1) + "\n", "the results");
    fmt::print(stderr, "results: {}\n", arguments.results);
    if (!no_figures) report.draw();
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const fs::filesystem_error& error) {
    fmt::print(stderr, "{}: {}: {}, expected a folder that can be written\n", name, error.path1().string(),
               error.code().message());
    return 2;
  } catch (const std::exception& error) {
    const bool refused = dynamic_cast<const Error*>(&error) || dynamic_cast<const CLI::ParseError*>(&error);
    fmt::print(stderr, "{}: {}{}\n", name, refused ? "" : "internal failure: ", error.what());
    return refused ? 2 : 1;
  }
  return 0;
}

std::vector<ListedTrial> seed_trials(const std::string& config, const Arguments& arguments,
                                     const std::vector<std::string>& set) {
  std::vector<ListedTrial> trials;
  for (const std::int64_t seed : arguments.seeds)
    trials.push_back({.config = config, .seed = seed, .set = set});
  return trials;
}

ListedTrial without_conditions(ListedTrial trial) {
  trial.profile = "imitation";
  return trial;
}

std::vector<ListedTrial> with_price(std::vector<ListedTrial> trials) {
  trials.push_back(without_conditions(trials.front()));
  return trials;
}

std::vector<ListedTrial> split_trials(const std::string& config, const Arguments& arguments) {
  std::vector<ListedTrial> trials;
  for (const std::vector<std::int64_t>& test :
       {{0, 1}, {2, 3}, {4, 5}, {6, 0}, std::vector<std::int64_t>{1, 5}}) {
    trials.push_back({.config = config, .test = test, .set = {"training.enlarge_rounds=0"}});
    if (arguments.quick) break;
  }
  return trials;
}

bool is_drawn(const Run& run, const Arguments& arguments) {
  return seed_run(run) && run.trial.seed == arguments.seeds.front();
}

void draw_all(const std::vector<Run>& runs, const Arguments& arguments) {
  for (const Run& run : runs) {
    if (!is_drawn(run, arguments)) continue;
    const fs::path folder = fs::path(arguments.out) / "figures" / run.label;
    fs::create_directories(folder);
    run_plot("plot_run", {run.path, "--out", folder});
  }
}

void draw_together(const std::string& name, const std::string& kind, const std::vector<Run>& runs,
                   const Arguments& arguments, const json& found) {
  const fs::path figures = fs::path(arguments.out) / "figures";
  fs::create_directories(figures);
  std::vector<std::string> words = {kind, figures / (name + ".png")};
  if (!found.is_null()) {
    words.push_back(fs::path(arguments.out) / (name + ".json"));
    write_atomic_file(words.back(), s2nnds::json_text(found), "what the figure shows");
  }
  for (const Run& run : runs) {
    if (is_drawn(run, arguments)) words.push_back(run.path);
  }
  run_plot("plot_paper", words);
}

Report report_runs(const std::vector<Run>& runs, const Arguments& arguments) {
  return {{{"runs", table_of_runs(runs)}, {"robustness", table_of_robustness(runs)}},
          [=] { draw_all(runs, arguments); }};
}

}  // namespace s2nnds::experiment
