// SPDX-License-Identifier: BSD-3-Clause
// The price of a certificate of the motion as executed: Table I's motions trained for robots that err by more and more.
//
// Rows, in the order in which they are run: velocities wrong by 0.05 (normalised); an arm at 1 kHz (preset arm_1khz) that
// draws each motion so large that its largest coordinate is 150 mm; nothing asked for, which the others are compared
// with, run by run; velocities wrong by 0.02, 0.01 and 0.1.
//
// Expected: nearly every run certified as executed, at some per cent of error and area.
//
// Usage: execution_table --data DIR [--out FOLDER] [--quick] [--finished]
#include <fmt/format.h>

#include <cmath>

#include "driver.h"

namespace {

using namespace s2nnds::experiment;
using nlohmann::json;

constexpr const char* kMotions[] = {"Sine",  "Sshape", "CShape", "Worm",
                                    "Angle", "GShape", "PShape", "NShape"};

struct Robot {
  std::string name;
  std::vector<std::string> set;
};

constexpr const char* ideal = "ideal";

const std::vector<Robot>& robots() {
  static const std::vector<Robot> all = [] {
    const auto wrong_by = [](double error) {
      return Robot{fmt::format("velocity_error {}", error),
                   {"execution.unit=normalised", fmt::format("execution.velocity_error={}", error)}};
    };
    return std::vector<Robot>{
        wrong_by(0.05), {"arm_1khz", {"execution.preset=arm_1khz", "execution.extent=150"}},
        {ideal, {}},    wrong_by(0.02),
        wrong_by(0.01), wrong_by(0.1)};
  }();
  return all;
}

std::vector<std::string> configs() {
  std::vector<std::string> all;
  for (const char* motion : kMotions) all.push_back(fmt::format("lasa/{}.toml", motion));
  return all;
}

// Robot by robot, and for each seed by seed.
std::vector<s2nnds::ListedTrial> trials(const Arguments& arguments) {
  std::vector<s2nnds::ListedTrial> all;
  for (const Robot& robot : robots()) {
    for (const std::int64_t seed : arguments.seeds) {
      for (const char* motion : kMotions) all.push_back({.config = motion, .seed = seed, .set = robot.set});
    }
  }
  return all;
}

bool is_certified(const Run& run) {
  const json& summary = run.summary;
  return is_invariant(run) &&
         (!summary.contains("execution") || summary["execution"]["invariant"].get<bool>());
}

// The sum of a figure over the row's runs, as a share of that over the ideal robot's runs of the same motions and seeds.
std::function<std::string(const Row&)> relative(const Figure& figure, const std::vector<Run>& ideal_runs) {
  return [=](const Row& row) {
    double sum = 0.0, of = 0.0;
    for (const Run& run : row.runs) {
      for (const Run& other : ideal_runs) {
        if (other.config != run.config || other.trial.seed != run.trial.seed) continue;
        const double here = figure(run), there = figure(other);
        if (std::isnan(here) || std::isnan(there)) continue;
        sum += here;
        of += there;
      }
    }
    return number_cell(sum / of, "{:.3f}");
  };
}

Report report(const std::vector<Run>& runs, const Arguments& arguments) {
  const auto per_robot = static_cast<std::int64_t>(trials(arguments).size() / robots().size());
  std::vector<Row> rows, motions;
  for (std::size_t k = 0; k < robots().size(); ++k) {
    const Robot& robot = robots()[k];
    const std::vector<Run> of_robot = select(
        runs, [&](const Run& run) { return run.trial.point / per_robot == static_cast<std::int64_t>(k); });
    rows.push_back({robot.name, of_robot, nullptr});
    for (const char* motion : kMotions) {
      motions.push_back({fmt::format("{}, {}", robot.name, motion),
                         select(of_robot, [&](const Run& run) { return run.config == motion; }), nullptr});
    }
  }
  std::vector<Run> ideal_runs;
  for (const Row& row : rows) {
    if (row.name == ideal) ideal_runs = row.runs;
  }
  const auto median_cell = [](const char* where, const char* form) {
    return median_of(any_run, in_summary(where), form);
  };
  const std::vector<Column> columns = {
      {"runs", [](const Row& row) { return fmt::format("{}", row.runs.size()); }},
      {"certified", share_of(any_run, is_certified)},
      {"test MSE", mean_of(any_run, in_summary("/mse_test"), "{:.4f}")},
      {"train MSE", mean_of(any_run, in_summary("/mse_train"), "{:.4f}")},
      {"safe area", mean_of(any_run, if_guaranteed("/safe_area"), "{:.2f}")},
      {"margin", median_cell("/disturbance_margin", "{:.3f}")},
      {"ball", median_cell("/execution/convergence_radius", "{:.2f}")},
      {"train s", median_cell("/seconds/training", "{:.0f}")},
      {"proof s", median_cell("/seconds/proof", "{:.2f}")},
      {"as executed s", median_cell("/seconds/execution", "{:.2f}")}};
  std::vector<Column> prices = columns;
  prices.push_back({"MSE to ideal", relative(in_summary("/mse_test"), ideal_runs)});
  prices.push_back({"area to ideal", relative(if_guaranteed("/safe_area"), ideal_runs)});
  return {{{"prices", make_table("robot", rows, prices)},
           {"motions", make_table("robot, motion", motions, columns)}},
          [] {}};
}

}  // namespace

int main(int argc, char** argv) {
  return run_driver(argc, argv,
                    {.name = "execution_table",
                     .about = "Table I's motions as robots execute them: what larger errors cost",
                     .configs = configs(),
                     .trials = trials,
                     .report = report});
}
