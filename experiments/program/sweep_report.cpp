#include "sweep_report.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "s2nnds/core/whole_file.h"
#include "s2nnds/sweeps/result_table.h"

namespace s2nnds::program {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t shown_points = 10;

std::string settings_text(const Sweep& sweep, std::int64_t point) {
  std::string text;
  for (std::size_t k = 0; k < sweep.axes.size(); ++k) {
    text += fmt::format("{}{}={}", k > 0 ? " " : "", sweep.axes[k].key, sweep.points[point][k]);
  }
  return text.empty() ? "(no axes)" : text;
}

void print_ranking(const Sweep& sweep, const std::vector<PointScore>& ranking) {
  fmt::print("{:>4} {:>6} {:>10} {:>8} {:>14}  settings\n", "rank", "point", "trials", "share",
             sweep.options.objective);
  for (std::size_t i = 0; i < std::min(shown_points, ranking.size()); ++i) {
    const PointScore& score = ranking[i];
    const std::string trials = fmt::format("{}/{}", score.trials - score.failed, sweep.trials_a_point());
    fmt::print("{:>4} {:>6} {:>10} {:>8.3g} {:>14.4g}  {}\n", i + 1, score.point, trials, score.share,
               score.objective, settings_text(sweep, score.point));
  }
  if (ranking.size() > shown_points) fmt::print("and {} more points\n", ranking.size() - shown_points);
}

ordered_json best_json(const Sweep& sweep, const PointScore& best) {
  ordered_json json;
  json["point"] = best.point;
  json["feasible"] = best.feasible;
  json["share"] = best.share;
  json["objective"] = std::isfinite(best.objective) ? ordered_json(best.objective) : ordered_json(nullptr);
  json["settings"] = ordered_json::object();
  for (std::size_t k = 0; k < sweep.axes.size(); ++k) {
    json["settings"][sweep.axes[k].key] = sweep.points[best.point][k];
  }
  return json;
}

}  // namespace

void print_trials(const Sweep& sweep, bool json) {
  fmt::print("{}: {} points ({}) x {} configurations x {} seeds = {} trials\n", sweep.options.name,
             sweep.points.size(), sweep.options.design, sweep.configs.size(), sweep.options.seeds.size(),
             sweep.trials_a_rung());
  if (sweep.options.rungs() > 1) {
    fmt::print("successive halving: {} = {}; the best {:.3g} of the points go on each time\n",
               sweep.options.halving.key, fmt::join(sweep.options.halving.budgets, ", "),
               sweep.options.halving.keep);
  }
  ordered_json list = ordered_json::array();
  for (std::int64_t id = 0; id < sweep.trials_a_rung(); ++id) {
    const Trial trial = sweep.trial(id);
    const BaseConfig& base = sweep.configs[trial.config];
    const std::int64_t seed = sweep.options.seeds[trial.seed];
    if (json) {
      list.push_back(
          {{"trial", id}, {"config", base.name}, {"seed", seed}, {"settings", sweep.settings(trial)}});
    } else {
      fmt::print("{:>7} {} seed={} {}\n", id, base.name, seed, settings_text(sweep, trial.point));
    }
  }
  if (json) fmt::print("{}\n", ordered_json({{"name", sweep.options.name}, {"trials", list}}).dump());
}

void write_tables(const Sweep& sweep, const SweepFolder& folder, const SweepState& state) {
  const ResultTable table = make_table(sweep, state);
  write_table(folder.file("table.h5"), table, sweep.options);
  write_whole_file(folder.file("table.csv"), to_csv(table), "the table");
}

bool print_report(const Sweep& sweep, const SweepFolder& folder, const SweepState& state, bool json) {
  std::int64_t failed = 0;
  for (const TrialResult& result : state.results) failed += result.failed ? 1 : 0;
  fmt::print("{}: {} trials ended, {} of them failed, {} missing", sweep.options.name, state.results.size(),
             failed, state.missing.size());
  if (sweep.options.rungs() > 1) fmt::print("; rung {} of {}", state.rung + 1, sweep.options.rungs());
  fmt::print("\n");
  const std::vector<PointScore> ranking = rank_points(sweep, state.of_rung);
  print_ranking(sweep, ranking);
  fmt::print("tables {} and table.csv\n", folder.file("table.h5"));
  const bool reached = !ranking.empty() && ranking.front().feasible;
  if (json) {
    ordered_json summary = {{"name", sweep.options.name},
                            {"ended", state.results.size()},
                            {"failed", failed},
                            {"missing", state.missing.size()},
                            {"rung", state.rung}};
    summary["best"] = ranking.empty() ? ordered_json(nullptr) : best_json(sweep, ranking.front());
    summary["table"] = folder.file("table.h5");
    fmt::print("{}\n", summary.dump());
  }
  return reached;
}

}  // namespace s2nnds::program
