// SPDX-License-Identifier: BSD-3-Clause
#include "run_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>

#include "s2nnds/core/check.h"
#include "s2nnds/evaluation/robustness.h"
#include "s2nnds/runs/prepared_run.h"

namespace s2nnds::experiment {
namespace {

using nlohmann::json;

std::string table_line(const std::vector<std::string>& cells) {
  std::string text = "|";
  for (const std::string& cell : cells) text += " " + cell + " |";
  return text + "\n";
}

double number_of(const json& value) { return value.is_number() ? value.get<double>() : std::nan(""); }

}  // namespace

std::vector<Run> select(const std::vector<Run>& runs, const std::function<bool(const Run&)>& accepts) {
  std::vector<Run> selected;
  std::copy_if(runs.begin(), runs.end(), std::back_inserter(selected), accepts);
  return selected;
}

Figure in_summary(const std::string& pointer) {
  return [where = json::json_pointer(pointer)](const Run& run) {
    return run.summary.contains(where) ? number_of(run.summary[where]) : std::nan("");
  };
}

Figure if_guaranteed(const std::string& pointer) {
  return [figure = in_summary(pointer)](const Run& run) {
    return run.guaranteed() ? figure(run) : std::nan("");
  };
}

double proof_boxes(const Run& run) {
  double boxes = 0.0;
  for (const json& condition : run.summary["conditions"])
    if (condition.contains("proof")) boxes += condition["proof"]["boxes"].get<double>();
  return boxes > 0.0 ? boxes : std::nan("");
}

std::vector<double> measured(const std::vector<Run>& runs, Role role, const Figure& figure) {
  std::vector<double> values;
  for (const Run& run : runs) {
    const double value = role(run) ? figure(run) : std::nan("");
    if (!std::isnan(value)) values.push_back(value);
  }
  return values;
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::string Table::text() const {
  std::string text = table_line(head) + "|";
  for (std::size_t k = 0; k < head.size(); ++k) text += "---|";
  text += "\n";
  for (const auto& row : rows) text += table_line(row);
  return text;
}

Table make_table(const std::string& first, const std::vector<Row>& rows, const std::vector<Column>& columns) {
  Table table{{first}, {}};
  for (const Column& column : columns) table.head.push_back(column.head);
  for (const Row& row : rows) {
    table.rows.push_back({row.name});
    for (const Column& column : columns) table.rows.back().push_back(column.cell(row));
  }
  return table;
}

std::string number_cell(double value, const std::string& form) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(form), value);
}

Cell median_of(Role role, const Figure& figure, const std::string& form) {
  return [=](const Row& row) { return number_cell(median(measured(row.runs, role, figure)), form); };
}

Cell mean_of(Role role, const Figure& figure, const std::string& form) {
  return [=](const Row& row) { return number_cell(mean(measured(row.runs, role, figure)), form); };
}

Cell least_of(Role role, const Figure& figure, const std::string& form) {
  return [=](const Row& row) {
    const std::vector<double> values = measured(row.runs, role, figure);
    return values.empty() ? "-" : number_cell(*std::min_element(values.begin(), values.end()), form);
  };
}

Cell known(const std::string& name, const std::string& form) {
  return [=](const Row& row) { return number_cell(number_of(row.known.at(name)), form); };
}

Cell share_of(Role role, Role having) {
  return [=](const Row& row) {
    const auto in_role = select(row.runs, role);
    return fmt::format("{}/{}", select(in_role, having).size(), in_role.size());
  };
}

Cell gaussian_process(const std::string& folder) {
  return [=](const Row& row) {
    const std::string path = S2NNDS_EXPERIMENTS "/results/baselines.json";
    std::ifstream file(path);
    check(file.good(), "{}: cannot be read, expected the figures of baselines.py", path);
    const nlohmann::json motion = nlohmann::json::parse(file).at("motions").at(folder + "/" + row.name);
    return number_cell(mean(motion.at("gaussian_process").at("mse").get<std::vector<double>>()), "{:.4f}");
  };
}

bool is_invariant(const Run& run) { return run.summary["guarantee"] == "invariant"; }

Table table_of_runs(const std::vector<Run>& runs) {
  const auto of = [](const Figure& figure, const std::string& form) {
    return median_of(any_run, figure, form);
  };
  std::vector<Row> rows;
  for (const Run& run : runs) rows.push_back({run.label, {run}, {}});
  return make_table(
      "run", rows,
      {{"guarantee", [](const Row& row) { return row.runs[0].summary["guarantee"].get<std::string>(); }},
       {"rounds", of(in_summary("/rounds"), "{:.0f}")},
       {"train s", of(in_summary("/seconds/training"), "{:.0f}")},
       {"proof s", of(in_summary("/seconds/proof"), "{:.2f}")},
       {"boxes", of(proof_boxes, "{:.0f}")},
       {"train MSE", of(in_summary("/mse_train"), "{:.4f}")},
       {"test MSE", of(in_summary("/mse_test"), "{:.4f}")},
       {"test SD", of(in_summary("/sd_test"), "{:.3f}")},
       {"test DTW", of(in_summary("/dtw_test"), "{:.4f}")},
       {"safe area", of(if_guaranteed("/safe_area"), "{:.2f}")},
       {"of true", of(if_guaranteed("/safe_area_ratio"), "{:.3f}")},
       {"margin", of(if_guaranteed("/disturbance_margin"), "{:.2g}")}});
}

Table table_of_robustness(const std::vector<Run>& runs) {
  Table table{{"run", "starts", "motions", "arrive", "without certificate", "in {B <= 0}", "of these arrive",
               "safe", "without", "closest to Xu", "without", "time to goal", "without"},
              {}};
  for (const Run& certified : select(runs, seed_run)) {
    const auto free = std::find_if(runs.begin(), runs.end(), [&](const Run& other) {
      return other.config == certified.config && other.trial.seed == certified.trial.seed &&
             other.trial.test.empty() && other.trial.profile == "imitation";
    });
    if (free == runs.end()) continue;
    const RunRecord record = certified.record();
    const PreparedRun setup = prepare(record);
    std::optional<StateFunction> B;
    if (certified.guaranteed()) B = record.networks.B;
    const auto ours =
        measure_robustness(record.networks.dynamics(), B, setup.problem, setup.demonstrations, 0);
    const auto theirs =
        measure_robustness(free->record().networks.dynamics(), {}, setup.problem, setup.demonstrations, 0);
    for (std::size_t k = 0; k < ours.size(); ++k) {
      const auto cell = [](double value) { return number_cell(value, "{:.3f}"); };
      table.rows.push_back(
          {certified.label, ours[k].starts, std::to_string(ours[k].motions), cell(ours[k].converged),
           cell(theirs[k].converged), certified.guaranteed() ? std::to_string(ours[k].covered) : "-",
           cell(ours[k].covered_converged), cell(ours[k].safe), cell(theirs[k].safe), cell(ours[k].closest),
           cell(theirs[k].closest), number_cell(ours[k].time_to_goal, "{:.2f}"),
           number_cell(theirs[k].time_to_goal, "{:.2f}")});
    }
  }
  return table;
}

}  // namespace s2nnds::experiment
