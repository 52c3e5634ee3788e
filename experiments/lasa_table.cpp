// SPDX-License-Identifier: BSD-3-Clause
// Table I and Fig. 2: eight LASA motions, each with its obstacle, learned and certified.
//
// Every problem is trained on its configuration's split (test demonstrations 5 and 6) with several seeds, and
// on five fixed splits with seed 0, once with all conditions and once without any (the price of the
// certificate). The five splits are trained without the rounds that only make B grow, which do not touch f.
//
// Expected (published: the paper's S2-NNDS and ABC-DS on a split of its own; test MSE in normalised units):
//   motion   S2-NNDS  ABC-DS
//   Sine     0.015    0.023
//   Sshape   0.016    0.014
//   CShape   0.019    0.029
//   Worm     0.026    -
//   Angle    0.044    -
//   GShape   0.019    0.041
//   PShape   0.008    0.027
//   NShape   0.084    0.020
// and every run `invariant`.
//
// Usage: lasa_table --data DIR [--out FOLDER] [--quick]
#include <fmt/format.h>

#include <cmath>

#include "driver.h"

namespace {

using namespace s2nnds::experiment;
using nlohmann::json;

struct Motion {
  const char* name;
  double published;
};
constexpr Motion kMotions[] = {{"Sine", 0.015},  {"Sshape", 0.016}, {"CShape", 0.019}, {"Worm", 0.026},
                               {"Angle", 0.044}, {"GShape", 0.019}, {"PShape", 0.008}, {"NShape", 0.084}};

std::vector<std::string> configs() {
  std::vector<std::string> all;
  for (const Motion& motion : kMotions) all.push_back(fmt::format("lasa/{}.toml", motion.name));
  return all;
}

std::vector<s2nnds::ListedTrial> trials(const Arguments& arguments) {
  std::vector<s2nnds::ListedTrial> all;
  for (const Motion& motion : kMotions) {
    append(all, with_price(seed_trials(motion.name, arguments)));
    for (const s2nnds::ListedTrial& split : split_trials(motion.name, arguments))
      append(all, {split, without_conditions(split)});
  }
  return all;
}

double first_clean_second(const Run& run) {
  return run.summary["seconds"].value("first_clean_round", HUGE_VAL);
}

// The price of the certificate: how much larger the error is than without conditions, over the splits.
std::string price(const Row& row) {
  return fmt::format("{:.2f}", mean(measured(row.runs, split_run, in_summary("/mse_test"))) /
                                   mean(measured(row.runs, free_split_run, in_summary("/mse_test"))));
}

Cell of_seeds(const Figure& figure, const std::string& form) { return median_of(seed_run, figure, form); }

// In normalised units, which differ from motion to motion.
std::string safe_area(const Row& row) {
  return row.known.is_null() ? "" : of_seeds(if_guaranteed("/safe_area"), "{:.2f}")(row);
}

const std::vector<Column> kGuarantees = {
    {"invariant", share_of(seed_run, is_invariant)},
    {"first s", of_seeds(first_clean_second, "{:.0f}")},
    {"train s", of_seeds(in_summary("/seconds/training"), "{:.0f}")},
    {"rounds", of_seeds(in_summary("/rounds"), "{:.0f}")},
    {"proof s", of_seeds(in_summary("/seconds/proof"), "{:.2f}")},
    {"boxes", of_seeds(proof_boxes, "{:.0f}")},
    {"safe area", safe_area},
    {"of true", of_seeds(if_guaranteed("/safe_area_ratio"), "{:.3f}")},
    {"margin", of_seeds(if_guaranteed("/disturbance_margin"), "{:.2g}")}};
const std::vector<Column> kAccuracy = {
    {"train MSE", of_seeds(in_summary("/mse_train"), "{:.4f}")},
    {"test MSE", of_seeds(in_summary("/mse_test"), "{:.4f}")},
    {"test SD", of_seeds(in_summary("/sd_test"), "{:.3f}")},
    {"test DTW", of_seeds(in_summary("/dtw_test"), "{:.4f}")},
    {"splits invariant", share_of(split_run, is_invariant)},
    {"mean of splits", mean_of(split_run, in_summary("/mse_test"), "{:.4f}")},
    {"best", least_of(split_run, in_summary("/mse_test"), "{:.4f}")},
    {"uncertified mean", mean_of(free_split_run, in_summary("/mse_test"), "{:.4f}")},
    {"price", price},
    {"GP mean", gaussian_process("lasa")},
    {"published", known("published", "{:.3f}")}};

Report report(const std::vector<Run>& runs, const Arguments& arguments) {
  std::vector<Row> motions;
  for (const Motion& motion : kMotions) {
    motions.push_back({motion.name, select(runs, [&](const Run& run) { return run.config == motion.name; }),
                       json::object({{"published", motion.published}})});
  }
  std::vector<Row> with_all = motions;
  with_all.push_back({"all", runs, nullptr});
  return {{{"guarantees", make_table("motion", with_all, kGuarantees)},
           {"accuracy", make_table("motion", motions, kAccuracy)},
           {"robustness", table_of_robustness(runs)}},
          [=] {
            draw_all(runs, arguments);
            draw_together("fig2", "panels", runs, arguments);
          }};
}

}  // namespace

int main(int argc, char** argv) {
  return run_driver(argc, argv,
                    {.name = "lasa_table",
                     .about = "Table I: eight LASA motions, learned and certified",
                     .configs = configs(),
                     .trials = trials,
                     .report = report});
}
