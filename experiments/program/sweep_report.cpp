#include "sweep_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "s2nnds/core/atomic_file.h"
#include "s2nnds/sweeps/result_table.h"

namespace s2nnds::program {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t shown_points = 10;
constexpr std::size_t name_width = 64;  // of the first column of the effects

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

std::string effect_text(const EffectFigure& figure, const Effect& effect) {
  return figure.factor ? fmt::format("x{:.3f} ±{:.3f}", effect.change, effect.error)
                       : fmt::format("{:+.3f} ±{:.3f}", effect.change, effect.error);
}

void print_effects(const Sweep& sweep, const EffectTable& effects) {
  std::vector<std::size_t> shown;
  for (std::size_t k = 0; k < effects.figures.size(); ++k) {
    if (effects.figures[k].told) shown.push_back(k);
  }
  if (shown.empty()) {
    if (!sweep.axes.empty()) fmt::print("effects: these trials do not tell the axes apart\n");
    return;
  }
  fmt::print("effects, each with the other axes as they are, ± standard error\n{:<{}}", "axis, from -> to",
             name_width);
  for (const std::size_t k : shown)
    fmt::print("{:>16} ({})", effects.figures[k].name, effects.figures[k].trials);
  fmt::print("\n");
  for (const AxisEffect& row : effects.rows) {
    const std::string name = fmt::format("{}, {} -> {}", row.axis, row.from, row.to);
    const bool fits = name.size() < name_width;
    if (!fits) fmt::print("{}\n", name);
    fmt::print("{:<{}}", fits ? name : "", name_width);
    for (const std::size_t k : shown) {
      const int width = 19 + static_cast<int>(std::to_string(effects.figures[k].trials).size());
      fmt::print("{:>{}}", effect_text(effects.figures[k], row.on[k]), width);
    }
    fmt::print("\n");
  }
}

ordered_json effects_json(const EffectTable& effects) {
  ordered_json list = ordered_json::array();
  for (const AxisEffect& row : effects.rows) {
    ordered_json item = {{"axis", row.axis}, {"from", row.from}, {"to", row.to}};
    for (std::size_t k = 0; k < effects.figures.size(); ++k) {
      const EffectFigure& figure = effects.figures[k];
      if (!figure.told) continue;
      item[figure.name] = {{figure.factor ? "factor" : "difference", row.on[k].change},
                           {"error", row.on[k].error},
                           {"trials", figure.trials}};
    }
    list.push_back(item);
  }
  return list;
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
  fmt::print("{}: {} points ({}) {} {} configurations x {} seeds = {} trials\n", sweep.options.name,
             sweep.points.size(), sweep.options.design, sweep.options.crossed ? "x" : "on one each of",
             sweep.configs.size(), sweep.options.seeds.size(), sweep.trials_a_rung());
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

void write_tables(const Sweep& sweep, const SweepFolder& folder, const SweepState& state,
                  const EffectTable& effects) {
  const ResultTable table = make_table(sweep, state);
  write_table(folder.file("table.h5"), table, effects, sweep.options);
  write_atomic_file(folder.file("table.csv"), to_csv(table), "the table");
}

bool print_report(const Sweep& sweep, const SweepFolder& folder, const SweepState& state,
                  const EffectTable& effects, bool json) {
  std::int64_t failed = 0;
  for (const TrialResult& result : state.results) failed += result.failed ? 1 : 0;
  fmt::print("{}: {} trials ended, {} of them failed, {} missing", sweep.options.name, state.results.size(),
             failed, state.missing.size());
  if (sweep.options.rungs() > 1) fmt::print("; rung {} of {}", state.rung + 1, sweep.options.rungs());
  fmt::print("\n");
  const std::vector<PointScore> ranking = rank_points(sweep, state.of_rung);
  if (sweep.options.crossed) print_ranking(sweep, ranking);  // else a point is as good as its problem is easy
  print_effects(sweep, effects);
  fmt::print("tables {} and table.csv\n", folder.file("table.h5"));
  const bool reached = !ranking.empty() && ranking.front().feasible;
  if (json) {
    ordered_json summary = {{"name", sweep.options.name},
                            {"ended", state.results.size()},
                            {"failed", failed},
                            {"missing", state.missing.size()},
                            {"rung", state.rung}};
    const bool ranked = sweep.options.crossed && !ranking.empty();
    summary["best"] = ranked ? best_json(sweep, ranking.front()) : ordered_json(nullptr);
    summary["effects"] = effects_json(effects);
    summary["table"] = folder.file("table.h5");
    fmt::print("{}\n", summary.dump());
  }
  return reached;
}

}  // namespace s2nnds::program
