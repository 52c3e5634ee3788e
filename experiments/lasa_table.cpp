// Table I and Fig. 2: eight LASA motions, each with its obstacle, learned and certified.
//
// Every problem is trained on its configuration's split (test demonstrations 5 and 6) with several seeds, and
// on five fixed splits with seed 0, once with all conditions and once without any (the price of the
// certificate). The five splits are trained without the rounds that only make B grow, which do not touch f.
//
// Expected (published: the paper's S2-NNDS on a split of its own; GP: a Gaussian process without
// certificates, mean over the five splits and the best of them; test MSE in normalised units):
//   motion   S2-NNDS  ABC-DS   GP mean  GP best
//   Sine     0.015    0.023    0.0247   0.0143
//   Sshape   0.016    0.014    0.0176   0.0099
//   CShape   0.019    0.029    0.0251   0.0159
//   Worm     0.026    -        0.0219   0.0129
//   Angle    0.044    -        0.0262   0.0172
//   GShape   0.019    0.041    0.0241   0.0194
//   PShape   0.008    0.027    0.0136   0.0100
//   NShape   0.084    0.020    0.0212   0.0085
// and every run `invariant`.
//
// Usage: lasa_table --data DIR [--out FOLDER] [--quick]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "trials.h"

namespace {

using namespace s2nnds::experiment;
using nlohmann::json;

struct Motion {
  const char* name;
  double published, gp_mean;
};
constexpr Motion kMotions[] = {{"Sine", 0.015, 0.0247},   {"Sshape", 0.016, 0.0176},
                               {"CShape", 0.019, 0.0251}, {"Worm", 0.026, 0.0219},
                               {"Angle", 0.044, 0.0262},  {"GShape", 0.019, 0.0241},
                               {"PShape", 0.008, 0.0136}, {"NShape", 0.084, 0.0212}};
std::vector<Trial> trials_of(const Motion& motion, const Arguments& arguments) {
  const std::string config = std::string("lasa/") + motion.name + ".toml";
  std::vector<Trial> trials = seed_trials(motion.name, config, arguments);
  for (const Trial& split : split_trials(motion.name, config, arguments)) {
    trials.push_back(split);
    std::vector<std::string> free = uncertified();
    free.push_back(split.assignments.front());
    trials.push_back({split.name + "-uncertified", config, free});
  }
  return trials;
}

struct Columns {
  std::map<std::string, std::vector<double>> of;  // by name, one value a run
  int runs = 0, invariant = 0, conformal = 0;

  void add(const json& summary) {
    ++runs;
    invariant += summary["guarantee"] == "invariant";
    bool passed = true;  // no counterexample among the samples either
    for (const json& condition : summary["conditions"]) {
      for (const char* method : {"sampled", "conformal"})
        passed = passed && (!condition.contains(method) || condition[method]["verdict"] == "passed");
    }
    conformal += passed;
    const json& seconds = summary["seconds"];
    of["first"].push_back(seconds.value("first_clean_round", HUGE_VAL));
    of["train"].push_back(seconds.at("training"));
    of["proof"].push_back(seconds.value("proof", std::nan("")));
    of["boxes"].push_back(proof_boxes(summary));
    for (const char* key : {"rounds", "mse_train", "mse_test", "sd_test", "dtw_test"})
      of[key].push_back(summary[key].is_null() ? std::nan("") : summary[key].get<double>());
    for (const char* key : {"safe_area", "safe_area_ratio", "disturbance_margin"}) {
      std::vector<double>& guaranteed = of[key];
      if (summary["guarantee"] != "none") guaranteed.push_back(summary[key]);
    }
  }
  double middle(const std::string& key) const { return median(of.at(key)); }
};

Report run(const Arguments& arguments) {
  std::vector<Trial> trials;
  for (const Motion& motion : kMotions)
    for (Trial& trial : trials_of(motion, arguments)) trials.push_back(std::move(trial));
  const std::vector<TrialResult> results = run_trials(trials, arguments);

  Table guarantees({"motion", "invariant", "conformal", "first s", "train s", "rounds", "proof s", "boxes",
                    "safe area", "of true", "margin"});
  Table accuracy({"motion", "train MSE", "test MSE", "test SD", "test DTW", "splits invariant",
                  "mean of splits", "best", "uncertified mean", "price", "GP mean", "published"});
  Columns all;
  for (const Motion& motion : kMotions) {
    Columns own;
    std::vector<double> certified, free;
    int invariant_splits = 0;
    for (const TrialResult& result : results) {
      if (result.trial.config != std::string("lasa/") + motion.name + ".toml") continue;
      const std::string& name = result.trial.name;
      const bool split = name.find("-test") != std::string::npos, without = name.ends_with("-uncertified");
      if (split) (without ? free : certified).push_back(result.summary["mse_test"]);
      invariant_splits += split && result.summary["guarantee"] == "invariant";
      if (split || without) continue;
      own.add(result.summary);
      all.add(result.summary);
    }
    guarantees.add({motion.name, fmt::format("{}/{}", own.invariant, own.runs),
                    fmt::format("{}/{}", own.conformal, own.runs), fmt::format("{:.0f}", own.middle("first")),
                    fmt::format("{:.0f}", own.middle("train")), fmt::format("{:.0f}", own.middle("rounds")),
                    fmt::format("{:.2f}", own.middle("proof")), fmt::format("{:.0f}", own.middle("boxes")),
                    fmt::format("{:.2f}", own.middle("safe_area")),
                    fmt::format("{:.3f}", own.middle("safe_area_ratio")),
                    fmt::format("{:.2g}", own.middle("disturbance_margin"))});
    accuracy.add({motion.name, fmt::format("{:.4f}", own.middle("mse_train")),
                  fmt::format("{:.4f}", own.middle("mse_test")), fmt::format("{:.3f}", own.middle("sd_test")),
                  fmt::format("{:.4f}", own.middle("dtw_test")),
                  fmt::format("{}/{}", invariant_splits, certified.size()),
                  fmt::format("{:.4f}", mean(certified)),
                  fmt::format("{:.4f}", *std::min_element(certified.begin(), certified.end())),
                  fmt::format("{:.4f}", mean(free)), fmt::format("{:.2f}", mean(certified) / mean(free)),
                  fmt::format("{:.4f}", motion.gp_mean), fmt::format("{:.3f}", motion.published)});
  }
  guarantees.add({"all", fmt::format("{}/{}", all.invariant, all.runs),
                  fmt::format("{}/{}", all.conformal, all.runs), fmt::format("{:.0f}", all.middle("first")),
                  fmt::format("{:.0f}", all.middle("train")), fmt::format("{:.0f}", all.middle("rounds")),
                  fmt::format("{:.2f}", all.middle("proof")), fmt::format("{:.0f}", all.middle("boxes")), "",
                  fmt::format("{:.3f}", all.middle("safe_area_ratio")),
                  fmt::format("{:.2g}", all.middle("disturbance_margin"))});
  const Table robustness = table_of_robustness(results, arguments);
  fmt::print("{}\n{}\n{}", guarantees.text(), accuracy.text(), robustness.text());
  return {{{"tables",
            {{"guarantees", guarantees.json()},
             {"accuracy", accuracy.json()},
             {"robustness", robustness.json()}}},
           {"runs", summaries_of(results)}},
          [=] {
            draw_all(results, arguments);
            draw_together("fig2", "panels", results, arguments);
          }};
}

}  // namespace

int main(int argc, char** argv) {
  return run_driver(argc, argv, "lasa_table", "Table I: eight LASA motions, learned and certified", run);
}
