// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "run_table.h"
#include "s2nnds/sweeps/sweep_options.h"

// A driver is a sweep with tables at its end: it lists trials of the configurations of experiments/configs,
// runs them as `s2nnds sweep` does, in a sweep's folder, and prints what came out.
namespace s2nnds::experiment {

struct Arguments {
  std::string data;                      // folder of the data files
  std::string out;                       // folder of the sweep
  std::string results;                   // JSON file
  std::vector<std::string> assignments;  // key=value, for every run
  std::vector<std::int64_t> seeds = {0, 1, 2};
  int jobs = 0;  // runs at a time; 0: one a core
  bool quick = false;
  bool finished = false;  // report what has ended, start nothing
};

// What a driver found, printed and written into its results file, and how its figures are drawn after that.
struct Report {
  std::vector<std::pair<std::string, Table>> tables;  // by name
  std::function<void()> draw;
  nlohmann::json more = nullptr;  // further entries of the results file
};

// One row a run, how robust the motions are, and figures of the first seed: all that a driver of few runs has
// to say.
Report report_runs(const std::vector<Run>& runs, const Arguments& arguments);

struct Driver {
  std::string name;                  // of its sweep and its results file
  std::string about;                 // one line, for --help
  std::vector<std::string> configs;  // under experiments/configs, such as "lasa/Sine.toml"
  std::function<std::vector<ListedTrial>(const Arguments&)> trials;
  std::function<Report(const std::vector<Run>&, const Arguments&)> report = report_runs;
};

// Reads the command line (--data, --out, --results, --set, --seeds, --jobs, --quick, --finished, --no-figures), runs the
// trials that have not ended yet, several at a time, writes the results file and draws. Returns the exit code.
// The same command goes on after an interruption; a folder of other trials is refused before anything starts;
// a run that fails is an error once all have ended (no certificate is no failure).
int run_driver(int argc, char** argv, const Driver& driver);

// Trials of the configuration of that name, one a seed.
std::vector<ListedTrial> seed_trials(const std::string& config, const Arguments& arguments,
                                     const std::vector<std::string>& set = {});

// The same trial with f fitted to the demonstrations and nothing else asked of it (the profile imitation).
ListedTrial without_conditions(ListedTrial trial);
// The trials, and the first of them without conditions: what the certificate costs is measured against it.
std::vector<ListedTrial> with_price(std::vector<ListedTrial> trials);

// Five fixed splits (two test demonstrations each; with --quick the first split alone), seed 0, without the
// rounds that only make B grow, which do not touch f.
std::vector<ListedTrial> split_trials(const std::string& config, const Arguments& arguments);

template <typename T>
void append(std::vector<T>& all, const std::vector<T>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

// A certified run of the first seed: the one that is drawn.
bool is_drawn(const Run& run, const Arguments& arguments);

// Draws the phase portrait and the other figures of each run that is_drawn into OUT/figures/LABEL.
void draw_all(const std::vector<Run>& runs, const Arguments& arguments);

// One figure of all of them, OUT/figures/NAME.png, by s2nnds.plot_paper: kind "panels", or "against", which wants
// the driver's results.
void draw_together(const std::string& name, const std::string& kind, const std::vector<Run>& runs,
                   const Arguments& arguments, const nlohmann::json& found = nullptr);

}  // namespace s2nnds::experiment
