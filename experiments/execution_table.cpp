// SPDX-License-Identifier: BSD-3-Clause
// The price of a certificate of the motion as executed: Table I's motions trained for robots that err by more and more.
//
// Rows: nothing asked for; velocities wrong by 0.01, 0.02, 0.05 and 0.1 (normalised); an arm at 1 kHz (preset
// arm_1khz) that draws each motion so large that its largest coordinate is 150 mm.
//
// Expected: nearly every run certified as executed, at some per cent of error and area.
//
// Usage: execution_table --data DIR [--out FOLDER] [--quick]
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

const std::vector<Robot>& robots() {
  static const std::vector<Robot> all = [] {
    std::vector<Robot> list = {{"ideal", {}}};
    for (const double error : {0.01, 0.02, 0.05, 0.1}) {
      list.push_back({fmt::format("velocity_error {}", error),
                      {"execution.unit=normalised", fmt::format("execution.velocity_error={}", error)}});
    }
    list.push_back({"arm_1khz", {"execution.preset=arm_1khz", "execution.extent=150"}});
    return list;
  }();
  return all;
}

std::vector<std::string> configs() {
  std::vector<std::string> all;
  for (const char* motion : kMotions) all.push_back(fmt::format("lasa/{}.toml", motion));
  return all;
}

// Robot by robot, and for each motion by motion.
std::vector<s2nnds::ListedTrial> trials(const Arguments& arguments) {
  std::vector<s2nnds::ListedTrial> all;
  for (const Robot& robot : robots()) {
    for (const char* motion : kMotions) append(all, seed_trials(motion, arguments, robot.set));
  }
  return all;
}

bool is_certified(const Run& run) {
  const json& summary = run.summary;
  return is_invariant(run) &&
         (!summary.contains("execution") || summary["execution"]["invariant"].get<bool>());
}

// The mean of a figure over the row's runs, as a share of that of the ideal robot's.
std::function<std::string(const Row&)> relative(const Figure& figure, const std::vector<Run>& ideal) {
  return [=](const Row& row) {
    return number_cell(mean(measured(row.runs, any_run, figure)) / mean(measured(ideal, any_run, figure)),
                       "{:.3f}");
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
  const std::vector<Run>& ideal = rows.front().runs;
  const auto median_cell = [](const char* where, const char* form) {
    return median_of(any_run, in_summary(where), form);
  };
  const std::vector<Column> columns = {{"certified", share_of(any_run, is_certified)},
                                       {"test MSE", mean_of(any_run, in_summary("/mse_test"), "{:.4f}")},
                                       {"train MSE", mean_of(any_run, in_summary("/mse_train"), "{:.4f}")},
                                       {"safe area", mean_of(any_run, if_guaranteed("/safe_area"), "{:.2f}")},
                                       {"margin", median_cell("/disturbance_margin", "{:.3f}")},
                                       {"ball", median_cell("/execution/convergence_radius", "{:.2f}")},
                                       {"train s", median_cell("/seconds/training", "{:.0f}")},
                                       {"proof s", median_cell("/seconds/proof", "{:.2f}")},
                                       {"as executed s", median_cell("/seconds/execution", "{:.2f}")}};
  std::vector<Column> prices = columns;
  prices.push_back({"MSE to ideal", relative(in_summary("/mse_test"), ideal)});
  prices.push_back({"area to ideal", relative(if_guaranteed("/safe_area"), ideal)});
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
