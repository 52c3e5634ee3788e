// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/displaced_obstacle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/settings.h"
#include "s2nnds/runs/scene_range.h"
#include "s2nnds/runs/user_units.h"

namespace s2nnds {
namespace {

constexpr double kRounding = 1e-9;  // of coordinates that someone wrote

// The keys that tell where a region lies; none where others do.
std::optional<std::vector<std::vector<double>*>> places_of(RegionOptions& region) {
  std::vector<std::vector<double>*> places;
  const std::string& type = region.type;
  if (type == "ball" || type == "ellipsoid" || type == "oriented_box" || type == "mesh" ||
      type == "point_cloud") {
    if (region.center.empty()) return std::nullopt;
    places = {&region.center};
  } else if (type == "box") {
    places = {&region.lower, &region.upper};
  } else if (type == "capsule" || type == "cylinder") {
    places = {&region.start, &region.end};
  } else if (type == "polygon" || (type == "polytope" && region.normals.empty())) {
    for (std::vector<double>& vertex : region.vertices) places.push_back(&vertex);
    for (PolygonHole& hole : region.holes)
      for (std::vector<double>& vertex : hole.vertices) places.push_back(&vertex);
  } else if (type == "union" || type == "intersection") {
    for (RegionOptions& part : region.of) {
      const auto inner = places_of(part);
      if (!inner) return std::nullopt;
      places.insert(places.end(), inner->begin(), inner->end());
    }
  } else {
    return std::nullopt;
  }
  return places;
}

// By what `after` is `before`, displaced: 0 where both are the same.
std::optional<Vector> shift_between(RegionOptions before, RegionOptions after) {
  const auto from = places_of(before), to = places_of(after);
  if (!from || !to || from->size() != to->size() || from->empty() ||
      from->front()->size() != to->front()->size())
    return std::nullopt;
  const auto n = std::ssize(*from->front());
  const Vector p =
      Eigen::Map<const Vector>(to->front()->data(), n) - Eigen::Map<const Vector>(from->front()->data(), n);
  for (std::size_t k = 0; k < from->size(); ++k) {
    std::vector<double>&a = *(*from)[k], &b = *(*to)[k];
    if (std::ssize(a) != n || std::ssize(b) != n) return std::nullopt;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double rest = b[i] - a[i] - p[static_cast<Eigen::Index>(i)];
      if (!(std::abs(rest) <= kRounding * (1.0 + std::abs(a[i]) + std::abs(b[i])))) return std::nullopt;
    }
    a = b;
  }
  if (flatten(before) != flatten(after)) return std::nullopt;
  return p;
}

}  // namespace

std::optional<DisplacedObstacle> displaced_obstacle(const RegionOptions& before, const RegionOptions& after) {
  if (const auto p = shift_between(before, after); p && !p->isZero(0.0)) return DisplacedObstacle{-1, *p};
  if (before.type != "union" || after.type != "union" || before.of.size() != after.of.size())
    return std::nullopt;
  std::optional<DisplacedObstacle> found;
  RegionOptions restored = after;
  for (std::size_t k = 0; k < before.of.size(); ++k) {
    if (before.of[k].type == "union") return std::nullopt;  // whose parts count on their own
    if (flatten(before.of[k]) == flatten(after.of[k])) continue;
    const auto p = shift_between(before.of[k], after.of[k]);
    if (!p || found) return std::nullopt;
    found = {static_cast<std::int64_t>(k), *p};
    restored.of[k] = before.of[k];
  }
  return flatten(restored) == flatten(before) ? found : std::nullopt;
}

std::string range_hint(const RunRecord& record, const std::vector<std::string>& settings) {
  const bool of_obstacle = std::all_of(settings.begin(), settings.end(), [](const std::string& setting) {
    return setting.starts_with("problem.unsafe");
  });
  if (!of_obstacle || record.certificate.guarantee != Guarantee::invariant) return "";
  try {
    const char* source = "the run's configuration";
    const PreparedRun setup = prepare(record);
    const Config changed = parse_config(with_settings(record.config.resolved, source, settings), source);
    const auto displaced = displaced_obstacle(setup.config.problem.unsafe, changed.problem.unsafe);
    if (!displaced) return "";
    const double scale = record.problem.frame == "data" ? record.data.frame.position_scale : 1.0;
    SceneRangeOptions options;
    if (displaced->index >= 0) options.obstacle = displaced->index;
    const SceneRange range = scene_range(setup, record, options);
    if (!range.holds(displaced->p / scale)) return "";
    return fmt::format(
        "the obstacle was only displaced, and the old run is certified for that as it is (by up to {}): "
        "`range` and `export "
        "--range` need no training",
        UserUnits(record).length(range.radius));
  } catch (const Error&) {
    return "";
  }
}

}  // namespace s2nnds
