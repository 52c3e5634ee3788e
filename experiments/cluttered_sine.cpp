// Fig. 5: LASA Sine below an obstacle whose edge is a sine itself, closer to the motion than the
// demonstrations are to each other.
//
// Expected: every seed `invariant`.
//
// Usage: cluttered_sine --data DIR [--out FOLDER] [--quick]
#include <fmt/core.h>

#include "trials.h"

namespace {

using namespace s2nnds::experiment;
using nlohmann::json;

json run(const Arguments& arguments) {
  std::vector<Trial> trials;
  for (const int seed : arguments.seeds)
    trials.push_back({fmt::format("cluttered_sine-seed{}", seed), "other/cluttered_sine.toml", {}, seed});
  const int first = arguments.seeds.front();
  trials.push_back({fmt::format("cluttered_sine-seed{}-uncertified", first), "other/cluttered_sine.toml",
                    uncertified(), first});
  const std::vector<TrialResult> results = run_trials(trials, arguments);
  const Table table = table_of_runs(results), robustness = table_of_robustness(results, arguments);
  fmt::print("{}\n{}", table.text(), robustness.text());
  if (arguments.figures)
    draw_all(results, arguments, [](const Trial& trial) { return trial.name.ends_with("-seed0"); });
  json runs = json::array();
  for (const TrialResult& result : results) runs.push_back(result.summary);
  return {{"tables", {{"runs", table.json()}, {"robustness", robustness.json()}}}, {"runs", runs}};
}

}  // namespace

int main(int argc, char** argv) {
  return run_driver(argc, argv, "cluttered_sine", "Fig. 5: a sine below a sine-shaped obstacle", run);
}
