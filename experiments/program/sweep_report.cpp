// SPDX-License-Identifier: BSD-3-Clause
#include "sweep_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "s2nnds/core/json_text.h"
#include "s2nnds/sweeps/result_table.h"

namespace s2nnds::program {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t shown_points = 10;

std::string axes_text(const Sweep& sweep, std::int64_t point) {
  std::string text;
  for (std::size_t k = 0; k < sweep.axes.size(); ++k) {
    text += fmt::format("{}{}={}", k > 0 ? " " : "", sweep.axes[k].key, sweep.points[point][k]);
  }
  return text;
}

void print_ranking(const Sweep& sweep, const std::vector<PointScore>& ranking) {
  fmt::print("{:>4} {:>6} {:>10} {:>8} {:>14}  settings\n", "rank", "point", "trials", "share",
             sweep.options.objective);
  for (std::size_t i = 0; i < std::min(shown_points, ranking.size()); ++i) {
    const PointScore& score = ranking[i];
    const std::string trials = fmt::format("{}/{}", score.trials - score.failed, sweep.trials_a_point());
    fmt::print("{:>4} {:>6} {:>10} {:>8.3g} {:>14.4g}  {}\n", i + 1, score.point, trials, score.share,
               score.objective, axes_text(sweep, score.point));
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
  const SweepOptions& options = sweep.options;
  if (options.trials.empty()) {
    fmt::print("{}: {} points ({}) {} {} configurations x {} seeds = {} trials\n", options.name,
               sweep.points.size(), options.design, options.crossed ? "x" : "on one each of",
               sweep.configs.size(), options.seeds.size(), sweep.trials_a_rung());
  } else {
    fmt::print("{}: {} trials\n", options.name, sweep.trials_a_rung());
  }
  if (options.rungs() > 1) {
    fmt::print("successive halving: {} = {}; the best {:.3g} of the points go on each time\n",
               options.halving.key, fmt::join(options.halving.budgets, ", "), options.halving.keep);
  }
  ordered_json list = ordered_json::array();
  for (std::int64_t id = 0; id < sweep.trials_a_rung(); ++id) {
    const Trial trial = sweep.trial(id);
    if (json) {
      list.push_back({{"trial", id},
                      {"config", sweep.configs[trial.config].name},
                      {"seed", trial.seed},
                      {"settings", sweep.settings(trial)}});
    } else {
      fmt::print("{:>7} {} {}\n", id, sweep.label(trial), axes_text(sweep, trial.point));
    }
  }
  if (json) fmt::print("{}\n", s2nnds::json_text(ordered_json({{"name", options.name}, {"trials", list}})));
}

bool report_sweep(const Sweep& sweep, const SweepFolder& folder, const SweepState& state, bool json) {
  write_tables(sweep, folder, state);
  const auto failed = std::count_if(state.results.begin(), state.results.end(),
                                    [](const TrialResult& result) { return result.failed; });
  fmt::print("{}: {} trials ended, {} of them failed, {} missing", sweep.options.name, state.results.size(),
             failed, state.missing.size());
  if (sweep.options.rungs() > 1) fmt::print("; rung {} of {}", state.rung + 1, sweep.options.rungs());
  fmt::print("\n");
  const std::vector<PointScore> ranking = rank_points(sweep, state.of_rung);
  if (sweep.is_conformal)
    fmt::print("conformal: beta is split over the sweep's {} trials, each is verified with its beta / {}\n",
               sweep.trials(), sweep.trials());
  const bool ranked = sweep.options.crossed;  // else a point is as good as its problem is easy
  if (ranked) print_ranking(sweep, ranking);
  fmt::print("tables {} and table.csv\n", folder.file("table.h5"));
  if (json) {
    ordered_json summary = {
        {"name", sweep.options.name},
        {"ended", state.results.size()},
        {"failed", failed},
        {"missing", state.missing.size()},
        {"rung", state.rung},
        {"best", ranked && !ranking.empty() ? best_json(sweep, ranking.front()) : ordered_json(nullptr)},
        {"table", folder.file("table.h5")}};
    if (sweep.is_conformal) summary["beta_split_over"] = sweep.trials();
    fmt::print("{}\n", s2nnds::json_text(summary));
  }
  return !ranking.empty() && ranking.front().feasible;
}

}  // namespace s2nnds::program
