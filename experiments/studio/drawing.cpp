// SPDX-License-Identifier: BSD-3-Clause
#include "drawing.h"

#include <fmt/format.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/toml_text.h"
#include "s2nnds/runs/version.h"

namespace s2nnds::studio {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::size_t kMostStrokes = 64, kMostSamples = 50'000, kMostObstacles = 64, kMostCorners = 256;
constexpr double kLargest = 1e9;  // of any coordinate
constexpr double kOneEnd = 0.01;  // ends closer than this share of the extent count as one
constexpr std::size_t kLongestName = 60;

const json& item(const json& from, const char* key) {
  check(from.is_object() && from.contains(key), "drawing: found no {}", key);
  return from[key];
}

double number(const json& from, const char* what) {
  check(from.is_number(), "drawing: {} is no number", what);
  const double value = from.get<double>();
  check(std::abs(value) <= kLargest, "drawing: {} is {}, expected at most {} in size", what, value, kLargest);
  return value;
}

std::vector<double> numbers(const json& from, const char* what, std::size_t most) {
  check(from.is_array() && from.size() <= most, "drawing: {} is no list of at most {} numbers", what, most);
  std::vector<double> values;
  for (const json& one : from) values.push_back(number(one, what));
  return values;
}

std::vector<double> point(const json& from, const char* what) {
  std::vector<double> values = numbers(from, what, 2);
  check(values.size() == 2, "drawing: {} has {} numbers, expected 2", what, values.size());
  return values;
}

// Names of files and of C++ namespaces are made of it.
std::string name(const json& from) {
  check(from.is_string(), "drawing: name is no text");
  const std::string text = from.get<std::string>();
  const bool plain =
      !text.empty() && text.size() <= kLongestName &&
      text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
          std::string::npos;
  check(plain, "drawing: found another name than 1 to {} letters, digits, - and _", kLongestName);
  return text;
}

std::string unit(const json& from) {
  check(from.is_string() && from.get<std::string>().size() <= 8,
        "drawing: unit is no text of at most 8 letters");
  const std::string text = from.get<std::string>();
  check(text.find_first_of("\"\\\n\r") == std::string::npos,
        "drawing: unit has a character that no unit has");
  return text;
}

Demonstration stroke(const json& from) {
  const std::vector<double> t = numbers(item(from, "t"), "t", kMostSamples);
  const std::vector<double> x = numbers(item(from, "x"), "x", kMostSamples);
  const std::vector<double> y = numbers(item(from, "y"), "y", kMostSamples);
  check(t.size() >= 2 && t.size() == x.size() && t.size() == y.size(),
        "drawing: a stroke has {} times, {} x and {} y; expected as many of each, two or more", t.size(),
        x.size(), y.size());
  Demonstration result;
  const auto rows = static_cast<Eigen::Index>(t.size());
  result.time = Eigen::Map<const Vector>(t.data(), rows);
  result.position.resize(rows, 2);
  result.position.col(0) = Eigen::Map<const Vector>(x.data(), rows);
  result.position.col(1) = Eigen::Map<const Vector>(y.data(), rows);
  return result;
}

RegionOptions shape(const json& from) {
  RegionOptions region;
  const json& type = item(from, "type");
  check(type.is_string(), "drawing: type is no text");
  region.type = type.get<std::string>();
  if (region.type == "ball") {
    region.center = point(item(from, "center"), "center");
    region.radius = number(item(from, "radius"), "radius");
  } else if (region.type == "box") {
    region.lower = point(item(from, "lower"), "lower");
    region.upper = point(item(from, "upper"), "upper");
  } else if (region.type == "polygon") {
    const json& vertices = item(from, "vertices");
    check(vertices.is_array() && vertices.size() >= 3 && vertices.size() <= kMostCorners,
          "drawing: a polygon has no list of 3 to {} corners", kMostCorners);
    for (const json& corner : vertices) region.vertices.push_back(point(corner, "a corner"));
  } else {
    fail("drawing: found another shape than ball, box, polygon");
  }
  return region;
}

// The value of a key that has a region, on one line.
std::string region_toml(const RegionOptions& region) {
  if (region.type == "ball") {
    return fmt::format("{{ type = \"ball\", center = {}, radius = {} }}", toml_text(region.center),
                       toml_text(region.radius));
  }
  if (region.type == "box") {
    return fmt::format("{{ type = \"box\", lower = {}, upper = {} }}", toml_text(region.lower),
                       toml_text(region.upper));
  }
  if (region.type == "polygon") {
    std::string corners;
    for (const auto& corner : region.vertices) corners += (corners.empty() ? "" : ", ") + toml_text(corner);
    return fmt::format("{{ type = \"polygon\", vertices = [{}] }}", corners);
  }
  return fmt::format("{{ type = {} }}", toml_text(region.type));
}

bool end_at_one_point(const Drawing& drawing) {
  Eigen::RowVector2d lower(INFINITY, INFINITY), upper = -lower, first = lower, last = upper;
  for (const Demonstration& d : drawing.strokes) {
    lower = lower.cwiseMin(d.position.colwise().minCoeff());
    upper = upper.cwiseMax(d.position.colwise().maxCoeff());
    first = first.cwiseMin(d.position.bottomRows(1));
    last = last.cwiseMax(d.position.bottomRows(1));
  }
  return drawing.strokes.empty() || (last - first).maxCoeff() <= kOneEnd * (upper - lower).maxCoeff();
}

}  // namespace

Drawing drawing_from(const json& from) {
  Drawing drawing;
  drawing.name = name(item(from, "name"));
  drawing.unit = unit(item(from, "unit"));
  drawing.field = numbers(item(from, "field"), "field", 4);
  check(
      drawing.field.size() == 4 && drawing.field[0] < drawing.field[2] && drawing.field[1] < drawing.field[3],
      "drawing: field is not the least corner and the other one");
  const double seed = number(item(from, "seed"), "seed");
  check(seed >= 0 && seed == std::floor(seed), "drawing: seed is {}, expected a whole number >= 0", seed);
  drawing.seed = static_cast<std::int64_t>(seed);
  const json& strokes = item(from, "strokes");
  check(strokes.is_array() && strokes.size() <= kMostStrokes, "drawing: strokes is no list of at most {}",
        kMostStrokes);
  Eigen::Index samples = 0;
  for (const json& one : strokes) {
    drawing.strokes.push_back(stroke(one));
    samples += drawing.strokes.back().position.rows();
  }
  check(samples <= static_cast<Eigen::Index>(kMostSamples), "drawing: found {} samples, expected at most {}",
        samples, kMostSamples);
  const json& obstacles = item(from, "obstacles");
  check(obstacles.is_array() && obstacles.size() <= kMostObstacles,
        "drawing: obstacles is no list of at most {}", kMostObstacles);
  for (const json& one : obstacles) drawing.obstacles.push_back(shape(one));
  const json& initial = item(from, "initial");
  if (!initial.is_null()) drawing.initial = shape(initial);
  return drawing;
}

ordered_json shape_json(const RegionOptions& region) {
  if (region.inflate != 0.0 || !region.holes.empty()) return nullptr;
  if (region.type == "ball") return {{"type", "ball"}, {"center", region.center}, {"radius", region.radius}};
  if (region.type == "box") return {{"type", "box"}, {"lower", region.lower}, {"upper", region.upper}};
  if (region.type == "polygon") return {{"type", "polygon"}, {"vertices", region.vertices}};
  return nullptr;
}

ordered_json obstacles_json(const RegionOptions& unsafe) {
  ordered_json all = ordered_json::array();
  if (unsafe.type == "none") return all;
  const bool several = unsafe.type == "union" && unsafe.inflate == 0.0;
  for (const RegionOptions& one : several ? unsafe.of : std::vector<RegionOptions>{unsafe}) {
    ordered_json shape = shape_json(one);
    if (shape.is_null()) return nullptr;
    all.push_back(std::move(shape));
  }
  return all;
}

ordered_json to_json(const Drawing& drawing) {
  ordered_json json = {{"name", drawing.name},
                       {"unit", drawing.unit},
                       {"field", drawing.field},
                       {"seed", drawing.seed},
                       {"strokes", ordered_json::array()},
                       {"obstacles", ordered_json::array()},
                       {"initial", shape_json(drawing.initial)}};
  for (const Demonstration& d : drawing.strokes) {
    const Vector x = d.position.col(0), y = d.position.col(1);
    json["strokes"].push_back({{"t", std::vector<double>(d.time.begin(), d.time.end())},
                               {"x", std::vector<double>(x.begin(), x.end())},
                               {"y", std::vector<double>(y.begin(), y.end())}});
  }
  for (const RegionOptions& one : drawing.obstacles) json["obstacles"].push_back(shape_json(one));
  return json;
}

std::string demonstrations_csv(const Drawing& drawing) {
  std::string text = "demonstration,time,x,y\n";
  for (std::size_t k = 0; k < drawing.strokes.size(); ++k) {
    const Demonstration& d = drawing.strokes[k];
    for (Eigen::Index i = 0; i < d.position.rows(); ++i)
      text += fmt::format("{},{},{},{}\n", k, d.time[i], d.position(i, 0), d.position(i, 1));
  }
  return text;
}

std::string unsafe_toml(const Drawing& drawing) {
  if (drawing.obstacles.empty()) return "{ type = \"none\" }";
  if (drawing.obstacles.size() == 1) return region_toml(drawing.obstacles.front());
  std::string all;
  for (const RegionOptions& one : drawing.obstacles) all += (all.empty() ? "" : ", ") + region_toml(one);
  return fmt::format("{{ type = \"union\", of = [{}] }}", all);
}

std::string configuration(const Drawing& drawing) {
  const std::vector<double>& field = drawing.field;
  return fmt::format(
      "# Drawn in the studio of s2nnds {}. With demonstrations.csv beside it this trains the same motion "
      "again:\n"
      "#   s2nnds train {}.toml --data . --out {}.h5\n"
      "name = {}\n"
      "seed = {}\n\n"
      "[data]\n"
      "source = \"csv\"\n"
      "files = [\"demonstrations.csv\"]\n"
      "state = \"position\"\n"  // the page draws motions x' = f(x) in the plane
      "columns = {{ time = \"time\", position = [\"x\", \"y\"], velocity = [\"none\"], index = "
      "\"demonstration\" }}\n"
      "time_unit = \"s\"\n"
      "unit = {}\n"
      "goal = \"{}\"\n"
      "test = []\n\n"
      "[problem]\n"
      "bounds = {{ lower = {}, upper = {} }}\n"
      "unsafe = {}\n"
      "initial = {}\n",
      program_version(), drawing.name, drawing.name, toml_text(drawing.name), drawing.seed,
      toml_text(drawing.unit), end_at_one_point(drawing) ? "mean" : "each",
      toml_text(std::vector<double>{field[0], field[1]}), toml_text(std::vector<double>{field[2], field[3]}),
      unsafe_toml(drawing), region_toml(drawing.initial));
}

}  // namespace s2nnds::studio
