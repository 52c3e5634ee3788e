// SPDX-License-Identifier: BSD-3-Clause
#include "range_command.h"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "run_report.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/json_text.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/range_motions.h"
#include "s2nnds/runs/summary.h"
#include "s2nnds/runs/threads.h"
#include "s2nnds/runs/user_units.h"

namespace s2nnds::program {
namespace {

using nlohmann::ordered_json;

std::optional<std::int64_t> number_of(const std::string& obstacle) {
  if (obstacle == "all") return std::nullopt;
  std::int64_t number = -1;
  const char* end = obstacle.data() + obstacle.size();
  const auto read = std::from_chars(obstacle.data(), end, number);
  check(
      read.ec == std::errc() && read.ptr == end && number >= 0,
      "range: found the obstacle \"{}\", expected a number from 0 in the order of problem.unsafe.of, or all",
      obstacle);
  return number;
}

std::vector<double> numbers(const Vector& x) { return {x.begin(), x.end()}; }

// In the data's unit and frame, but for what is a share.
ordered_json range_json(const RunRecord& record, const SceneRange& range, const RangeMotions& motions) {
  const Frame& frame = record.data.frame;
  const Vector& center = range.displacement.center();
  const double length = frame.position_scale;
  return {{"statement", range_statement(record, range)},
          {"obstacle", range.index < 0 ? ordered_json("all") : ordered_json(range.index)},
          {"radius", length * range.radius},
          {"half_sizes", numbers(length * range.half_sizes)},
          {"center", numbers(frame.goal.head(center.size()) + length * center)},
          {"inner", length * range.displacement.inner()},
          {"outer", length * range.displacement.outer()},
          {"limit", range.limit},
          {"stretch", range.stretch},
          {"margin", frame.velocity_scale * range.margin},
          {"deviation",
           {{"mean_before", length * motions.mean_before},
            {"mean", length * motions.mean},
            {"largest_before", length * motions.largest_before},
            {"largest", length * motions.largest}}},
          {"motions", motions.motions},
          {"arrived", motions.arrived}};
}

}  // namespace

SceneRange chosen_range(const RangeChoice& choice, const PreparedRun& setup, const RunRecord& record) {
  SceneRangeOptions options;
  options.obstacle = number_of(choice.obstacle);
  options.stretch = choice.stretch;
  const auto count = static_cast<Eigen::Index>(choice.within.size()), places = setup.problem.places();
  const Vector within =
      Eigen::Map<const Vector>(choice.within.data(), count) / setup.data.frame.position_scale;
  check(count == 0 || ((count == 1 || count == places) && (within.array() > 0.0).all() && within.allFinite()),
        "range: found --within with {} numbers, expected a radius, or {} half sizes of a box, > 0", count,
        places);
  if (count == 1)
    options.radius = within[0];
  else
    options.half_sizes = within;
  return scene_range(setup, record, options);
}

int range(const RangeArguments& arguments, const CommonArguments& common) {
  set_threads(common.threads);
  const RunRecord record = load_certified_run(arguments.run);
  const PreparedRun setup = prepare(record);
  const SceneRange found = chosen_range(arguments.choice, setup, record);
  const RangeMotions motions = motions_at_ends(setup, record, found);
  const UserUnits units(record);
  fmt::print("{} (seed {}): guarantee INVARIANT, for a range of scenes\n{}\n", record.name, record.seed,
             paragraph(range_statement(record, found)));
  fmt::print("{}",
             row("obstacle", "within " + units.length(found.displacement.inner()) + " of its middle") +
                 row("deviation", fmt::format("mean {}; before {}", units.length(motions.mean),
                                              units.length(motions.mean_before))) +
                 row("", fmt::format("largest {}; before {}", units.length(motions.largest),
                                     units.length(motions.largest_before))) +
                 row("motions", fmt::format("{} of {} from demonstrated starts arrive at the range's ends",
                                            motions.arrived, motions.motions)));
  if (common.json) {
    ordered_json summary = ordered_json::parse(summary_json(record, arguments.run));
    summary["range"] = range_json(record, found, motions);
    fmt::print("{}\n", s2nnds::json_text(summary));
  }
  return kVerified;
}

}  // namespace s2nnds::program
