// Fig. 3: a kinesthetic C-shaped motion in three dimensions around a ball, ten of fifteen demonstrations
// train.
//
// Expected: every seed `invariant`; the proof takes about a million boxes.
//
// Usage: cshape_3d --data DIR [--out FOLDER] [--quick]
#include <fmt/core.h>

#include "trials.h"

namespace {

using namespace s2nnds::experiment;
using nlohmann::json;

json run(const Arguments& arguments) {
  std::vector<Trial> trials;
  for (const int seed : arguments.seeds)
    trials.push_back({fmt::format("cshape_3d-seed{}", seed), "other/cshape_3d.toml", {}, seed});
  const int first = arguments.seeds.front();
  trials.push_back(
      {fmt::format("cshape_3d-seed{}-uncertified", first), "other/cshape_3d.toml", uncertified(), first});
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
  return run_driver(argc, argv, "cshape_3d", "Fig. 3: a motion in three dimensions around a ball", run);
}
