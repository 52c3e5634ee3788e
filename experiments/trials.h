#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "s2nnds/runs/run_record.h"

// What the drivers have in common: runs of the program s2nnds, several at a time, and what is made of them.
namespace s2nnds::experiment {

// A table in Markdown.
class Table {
 public:
  explicit Table(std::vector<std::string> head) : head_(std::move(head)) {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  std::string text() const;
  nlohmann::json json() const;  // {"head": [...], "rows": [[...], ...]}

 private:
  std::vector<std::string> head_;
  std::vector<std::vector<std::string>> rows_;
};

struct Arguments {
  std::string data;                      // folder of the data files
  std::string out;                       // folder of the run files
  std::string results;                   // JSON file
  std::vector<std::string> assignments;  // key=value, for every run
  std::vector<int> seeds = {0, 1, 2};
  int jobs = 0;  // runs at a time; 0: one a core
  bool quick = false;
  bool figures = true;
};

// One run: a configuration of experiments/configs, with changes.
struct Trial {
  std::string name;                      // of its files in the folder of the runs
  std::string config;                    // under experiments/configs, such as "lasa/Sine.toml"
  std::vector<std::string> assignments;  // key=value
  int seed = 0;
};

struct TrialResult {
  Trial trial;
  std::string run;  // path of the run file
  RunRecord record;
  nlohmann::json summary;  // as `s2nnds train --json` prints it
};

// Runs the trials, each in its own process with its share of the cores, and returns them in their order. A
// trial whose finished run file is there already, of the same configuration, is not repeated; one that was
// interrupted goes on; a file of another configuration in its place is an error before any run begins. Says
// on stderr how far it is. Throws Error when a run fails (ending without a certificate is no failure).
std::vector<TrialResult> run_trials(const std::vector<Trial>& trials, const Arguments& arguments);

// Draws the phase portrait and the other figures of each run that is_drawn names into OUT/figures/NAME.
void draw_all(const std::vector<TrialResult>& results, const Arguments& arguments);

// One figure of all of them, OUT/figures/NAME.png, by plot_paper.py: kind "panels", or "against", which wants
// the driver's results.
void draw_together(const std::string& name, const std::string& kind, const std::vector<TrialResult>& results,
                   const Arguments& arguments, const nlohmann::json& found = nullptr);

// The problem's trials: NAME-seedK for every seed, and NAME-seedK-uncertified for the first of them.
std::vector<Trial> seed_trials(const std::string& name, const std::string& config, const Arguments& arguments,
                               const std::vector<std::string>& assignments = {});

// NAME-testAB for the five fixed splits (test demonstrations A and B; with --quick the first one alone), seed
// 0, without the rounds that only make B grow, which do not touch f.
std::vector<Trial> split_trials(const std::string& name, const std::string& config,
                                const Arguments& arguments);

// What a driver found, and how its figures are drawn once that is written down.
struct Report {
  nlohmann::json results;
  std::function<void()> draw;
};

// Prints one row a run and how robust the motions are; both tables and the runs for the results file, and
// figures of the first seed: all that a driver of few runs has to say.
Report report_runs(const std::vector<TrialResult>& results, const Arguments& arguments);

// The runs' summaries, each with its trial's name.
nlohmann::json summaries_of(const std::vector<TrialResult>& results);

// A certified trial of the first seed: the one that is drawn.
bool is_drawn(const Trial& trial, const Arguments& arguments);

// Boxes of the proofs of all conditions.
double proof_boxes(const nlohmann::json& summary);

// Settings that fit f to the demonstrations and ask nothing else of it: what the certificate costs is
// measured against such a run. Five rounds, as many as a certified run has at least.
std::vector<std::string> uncertified();

// Runs a driver: its command line (--data, --out, --results, --set, --seeds, --jobs, --quick, --no-figures),
// then `body`, whose results go to the results file beside the program's version, time and arguments, then
// its figures. Returns the exit code. `name` is the driver's.
int run_driver(int argc, char** argv, const std::string& name, const std::string& about,
               const std::function<Report(const Arguments&)>& body);

// One row a run: what is guaranteed, and how good the motion is.
Table table_of_runs(const std::vector<TrialResult>& results);

// Motions from a grid, from perturbed starts and with a push half way (evaluation/robustness.h), under the
// certified f and under the f of the same name with "-uncertified" behind, for all results but the splits
// ("-test") that have one. Rows are named by the certified trial.
Table table_of_robustness(const std::vector<TrialResult>& results, const Arguments& arguments);

double median(std::vector<double> values);  // NaN if there are none
double mean(const std::vector<double>& values);

}  // namespace s2nnds::experiment
