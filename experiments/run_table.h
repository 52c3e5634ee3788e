// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "s2nnds/runs/run_record.h"
#include "s2nnds/sweeps/sweep.h"

// Tables of finished runs.
namespace s2nnds::experiment {

struct Run {
  Trial trial;
  std::string config;  // the name of its configuration
  std::string label;   // Sweep::label
  std::string path;
  nlohmann::json summary;  // as `s2nnds train --json` prints it

  RunRecord record() const { return load_run(path); }
  bool guaranteed() const { return summary["guarantee"] != "none"; }
};

// Roles of runs.
using Role = bool (*)(const Run&);
inline bool any_run(const Run&) { return true; }
inline bool seed_run(const Run& run) { return run.trial.test.empty() && run.trial.profile.empty(); }
inline bool split_run(const Run& run) { return !run.trial.test.empty() && run.trial.profile.empty(); }
inline bool free_split_run(const Run& run) {  // without conditions
  return !run.trial.test.empty() && run.trial.profile == "imitation";
}

std::vector<Run> select(const std::vector<Run>& runs, const std::function<bool(const Run&)>& accepts);

// A figure of a run, NaN where it was not measured.
using Figure = std::function<double(const Run&)>;
Figure in_summary(const std::string& pointer);  // such as "/seconds/training"
// The same where there is a guarantee, without which {B <= 0} is no safe set.
Figure if_guaranteed(const std::string& pointer);
double proof_boxes(const Run& run);  // of all conditions

std::vector<double> measured(const std::vector<Run>& runs, Role role, const Figure& figure);
double median(std::vector<double> values);  // NaN if there are none
double mean(const std::vector<double>& values);

// A table in Markdown, of which every cell is a function of its row: some runs, and what else is known of
// them.
struct Row {
  std::string name;
  std::vector<Run> runs;
  nlohmann::json known;  // figures that are not of these runs, such as published ones
};
struct Column {
  std::string head;
  std::function<std::string(const Row&)> cell;
};
struct Table {
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;

  std::string text() const;
  nlohmann::json json() const { return {{"head", head}, {"rows", rows}}; }
};
// The first column holds the rows' names.
Table make_table(const std::string& first, const std::vector<Row>& rows, const std::vector<Column>& columns);

// Cells of columns; `form` is fmt's, such as "{:.4f}", and NaN is "-".
using Cell = std::function<std::string(const Row&)>;
std::string number_cell(double value, const std::string& form);
Cell median_of(Role role, const Figure& figure, const std::string& form);
Cell mean_of(Role role, const Figure& figure, const std::string& form);
Cell least_of(Role role, const Figure& figure, const std::string& form);
Cell known(const std::string& name, const std::string& form);
Cell share_of(Role role, Role having);  // "2/3"
// Mean test MSE of the Gaussian process of baselines.py on the configuration FOLDER/ROW.
Cell gaussian_process(const std::string& folder);
bool is_invariant(const Run& run);

// One row a run: what is guaranteed, and how good the motion is.
Table table_of_runs(const std::vector<Run>& runs);

// Motions from a grid, from perturbed starts and with a push half way (evaluation/robustness.h), under the
// certified f and under that of the same configuration and seed without conditions; of seed runs that have
// such a counterpart.
Table table_of_robustness(const std::vector<Run>& runs);

}  // namespace s2nnds::experiment
