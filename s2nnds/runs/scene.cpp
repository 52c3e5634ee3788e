// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/hdf5.h"
#include "s2nnds/problem/grid_level.h"
#include "s2nnds/problem/passing_sides.h"
#include "s2nnds/problem/reachability.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kPlaces = 400;         // of a demonstration, whose clearance is measured
constexpr double kClearanceTolerance = 1e-3;  // normalised
constexpr std::size_t kMostNamed = 3;         // of one kind of warning

std::string with_unit(double value, const std::string& unit) {
  return fmt::format("{:.3g}{}{}", value, unit.empty() ? "" : " ", unit);
}

double degrees(double radians) { return radians * 180 / M_PI; }

// The first of several texts, and how many more there are.
void add_some(std::vector<std::string>& all, const std::vector<std::string>& texts) {
  for (std::size_t i = 0; i < std::min(texts.size(), kMostNamed); ++i) all.push_back(texts[i]);
  if (texts.size() > kMostNamed)
    all.push_back(fmt::format("... and {} more of this kind", texts.size() - kMostNamed));
}

std::string crossing_text(const Crossing& c, double extent, const std::string& unit) {
  const std::string place = place_text(c.place, extent, unit);
  if (c.first == c.second) {
    return fmt::format(
        "demonstration {} is at {} twice, at {:.3g} s and {:.3g} s, in directions {:.0f} degrees apart: it "
        "crosses itself, and a law x' = f(x) cannot tell the two branches apart; choose data.state = "
        "\"phase\", which can, or cut the recording",
        c.first, place, c.first_time, c.second_time, degrees(c.angle));
  }
  return fmt::format(
      "demonstrations {} and {} pass {} in directions {:.0f} degrees apart, at {:.3g} s and {:.3g} s: a law "
      "x' = "
      "f(x) has one direction there and cannot follow both; leave one out (data.use)",
      c.first, c.second, place, degrees(c.angle), c.first_time, c.second_time);
}

Points first_points(const std::vector<Demonstration>& demonstrations) {
  Points starts(static_cast<Eigen::Index>(demonstrations.size()), demonstrations.front().dimension());
  for (Eigen::Index k = 0; k < starts.rows(); ++k)
    starts.row(k) = demonstrations[static_cast<std::size_t>(k)].position.row(0);
  return starts;
}

void warn_of_clearances(Scene& scene) {
  std::vector<std::string> texts;
  const std::vector<std::string> all = clearance_texts(scene.clearances, *scene.frame);
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (scene.clearances[k].inside > 0) {
      texts.push_back(fmt::format("demonstration {} {}: the motion will leave it there", k, all[k]));
    }
  }
  add_some(scene.warnings, texts);
}

// The sets, refused or not.
void build_problem(Scene& scene, const std::string& data_dir) {
  const std::vector<Demonstration> normalised = scene.frame->normalize(scene.states);
  RegionFiles files(data_dir);
  try {
    scene.problem = make_problem(scene.config.problem, normalised, *scene.frame, files);
  } catch (const Error& error) {
    scene.refusals.emplace_back(error.what());
    try {
      scene.problem = draft_problem(scene.config.problem, normalised, *scene.frame, files);
    } catch (const Error&) {
      return;  // a set cannot be made at all, as the refusal says
    }
  }
  try {
    scene.clearances = clearances_of(*scene.problem, scene.config.problem, normalised, *scene.frame);
    warn_of_clearances(scene);
    for (std::string& text : impossibilities(*scene.problem, *scene.frame, normalised))
      scene.warnings.push_back(std::move(text));
    if (auto text = sides_warning(*scene.problem, *scene.frame, normalised))
      scene.warnings.push_back(std::move(*text));
  } catch (const Error& error) {  // a level that is not a number somewhere
    if (scene.refusals.empty()) scene.refusals.emplace_back(error.what());
    scene.problem.reset();
    scene.clearances.clear();
  }
}

Array grid_of(const Vector& values, Eigen::Index dimension, Eigen::Index side) {
  return {std::vector<Eigen::Index>(static_cast<std::size_t>(dimension), side),
          {values.begin(), values.end()}};
}

// Levels of the sets on a grid over the workspace, in the data's frame; of a phase, where it starts.
void write_sets(Hdf5Writer& file, const Scene& scene) {
  const Frame& frame = *scene.frame;
  const SafetyProblem& problem = *scene.problem;
  const Eigen::Index n = problem.places();
  file.write("/workspace/lower", Vector(frame.to_data(problem.workspace.lower).head(n)));
  file.write("/workspace/upper", Vector(frame.to_data(problem.workspace.upper).head(n)));
  if (n > 3) return;
  const Eigen::Index side = n == 2 ? 301 : 51;
  std::vector<Vector> axes;
  for (Eigen::Index i = 0; i < n; ++i) {
    axes.push_back(Vector::LinSpaced(side, problem.workspace.lower[i], problem.workspace.upper[i]));
    file.write(fmt::format("/axes/{}", i),
               Vector((frame.position_scale * axes.back()).array() + frame.goal[i]));
  }
  if (problem.has_phase()) axes.push_back(Vector::Constant(1, problem.phase_start));
  const auto level = [&](const Region& region) {
    const Vector values = grid_level(region, axes);
    return grid_of(values.cwiseMax(-1e6).cwiseMin(1e6), n, side);  // an empty region's is infinite
  };
  file.write("/unsafe", level(*problem.unsafe));
  file.write("/initial", level(*problem.initial));
}

}  // namespace

std::string place_text(const Vector& place, double extent, const std::string& unit) {
  const double digits = std::pow(10.0, 3 - std::floor(std::log10(extent > 0 ? extent : 1)));
  std::vector<double> shown;
  for (const double coordinate : place) shown.push_back(std::round(coordinate * digits) / digits + 0.0);
  return fmt::format("({:.6g}){}{}", fmt::join(shown, ", "), unit.empty() ? "" : " ", unit);
}

std::vector<std::string> warnings_of(const Survey& survey, const std::string& unit, bool has_phase) {
  std::vector<std::string> warnings, closed, crossings, pauses;
  for (Eigen::Index k = 0; k < survey.closing.size(); ++k) {
    if (!survey.is_closed(k)) continue;
    closed.push_back(fmt::format(
        "demonstration {} ends where it starts ({} apart): the start is the goal, and a law x' = f(x) that "
        "converges stays there; choose data.state = \"phase\", or cut the recording into parts",
        k, with_unit(survey.closing[k] < 1e-9 * survey.extent ? 0 : survey.closing[k], unit)));
  }
  for (const Crossing& crossing : survey.crossings)
    crossings.push_back(crossing_text(crossing, survey.extent, unit));
  for (const Pause& pause : survey.pauses) {
    pauses.push_back(fmt::format(
        "demonstration {} stops for {:.2g} s at {}, {:.3g} s after its start: a law x' = f(x) would stay "
        "there for "
        "ever, so the stop is not learned",
        pause.demonstration, pause.duration, place_text(pause.place, survey.extent, unit), pause.start));
  }
  if (has_phase) closed.clear(), crossings.clear();
  for (const auto& texts : {closed, crossings, pauses}) add_some(warnings, texts);
  return warnings;
}

std::vector<std::string> impossibilities(const SafetyProblem& problem, const Frame& frame,
                                         const std::vector<Demonstration>& normalised) {
  const auto found = find_reachability(problem, first_points(normalised));
  if (!found || found->cut_off == 0) return {};
  const std::string grid = fmt::format("on a grid of {} cells a side", found->cells);
  if (found->goal_is_walled_in)
    return {fmt::format("the obstacle cuts the goal off from every start ({}): no motion can be safe", grid)};
  return {fmt::format(
      "the obstacle cuts {:.0f} % of the initial set and the starts off from the goal, as at {} ({}): no "
      "motion from there can be safe; make problem.initial smaller",
      std::ceil(100 * found->cut_off), frame.position_text(frame.to_data(found->place)), grid)};
}

std::optional<std::string> sides_warning(const SafetyProblem& problem, const Frame& frame,
                                         const std::vector<Demonstration>& normalised) {
  const auto found = find_passing_sides(problem, normalised);
  if (!found) return std::nullopt;
  return fmt::format(
      "demonstrations {} and {} start together and pass the obstacle at {} on different sides: a motion x' = "
      "f(x) "
      "from there takes one way only",
      found->first, found->second, frame.position_text(frame.to_data(found->place)));
}

std::string dimension_warning(Config config, Eigen::Index dimension) {
  config.choose_for(dimension);
  if (dimension == most_proved_dimensions && config.profile == "robust" &&
      config.verification.method == Method::proof) {
    return fmt::format(
        "a proof in {} dimensions ends in minutes with profile = \"smooth\"; with the networks of robust it "
        "may "
        "take many times as many boxes, or not end",
        dimension);
  }
  if (dimension <= most_proved_dimensions || config.verification.method != Method::proof) return "";
  return fmt::format(
      "a proof in {} dimensions is hardly to be hoped for: it gives up, mostly within half a minute, where "
      "far more boxes than allowed seem to be needed, and then nothing is guaranteed. verification.method = "
      "\"conformal\" speaks of drawn points instead, and is over in minutes",
      dimension);
}

std::vector<Clearance> clearances_of(const SafetyProblem& problem, const ProblemOptions& options,
                                     const std::vector<Demonstration>& normalised, const Frame& frame) {
  std::vector<Clearance> clearances;
  if (options.unsafe.type == "none") return clearances;
  for (const Demonstration& d : normalised) {
    Clearance found =
        clearance(*problem.unsafe, along_path(d.position, kPlaces), problem.workspace, kClearanceTolerance);
    found.distance *= frame.position_scale;
    if (found.at.size() > 0) {
      found.at = frame.to_data(found.at);
      found.in_region = frame.to_data(found.in_region);
    }
    clearances.push_back(std::move(found));
  }
  return clearances;
}

std::vector<std::string> clearance_texts(const std::vector<Clearance>& clearances, const Frame& frame) {
  std::vector<std::string> texts;
  for (const Clearance& c : clearances) {
    if (c.inside > 0) {
      texts.push_back(fmt::format("passes through the obstacle on {:.0f} % of its way, as at {}",
                                  std::ceil(100.0 * static_cast<double>(c.inside) / kPlaces),
                                  frame.position_text(c.at)));
    } else if (std::isinf(c.distance)) {
      texts.emplace_back("no obstacle in the workspace");
    } else {
      texts.push_back(with_unit(c.distance, frame.unit));
    }
  }
  return texts;
}

Scene look_at(const Config& config, const std::string& data_dir, const ReadingProgress& progress) {
  Scene scene;
  scene.config = config;
  scene.data = read_demonstrations(config.data, data_dir, progress);
  scene.survey = survey(scene.data);
  scene.phase = choose_phase(config.data.state, scene.data, scene.survey);
  if (scene.phase.used) scene.data.report.push_back(scene.phase.reason);
  scene.warnings = warnings_of(scene.survey, scene.data.unit, scene.phase.used);
  try {
    split_demonstrations(scene.data.demonstrations.size(), config.data.test, config.data.validation);
    DemonstrationSet states = scene.data;
    Frame frame = find_frame(states, config.data.normalization, config.data.goal);
    if (scene.phase.used) frame = add_phase(states, frame);
    frame.name = config.data.frame_name;
    scene.frame = std::move(frame);
    scene.states = std::move(states.demonstrations);
  } catch (const Error& error) {
    scene.refusals.emplace_back(error.what());
  }
  if (scene.frame) build_problem(scene, data_dir);
  return scene;
}

void save_scene(const std::string& path, const Scene& scene) {
  Hdf5Writer file(path);
  file.make_group("/demonstrations");
  file.write_attribute("/demonstrations", "name", scene.config.name);
  file.write_attribute("/demonstrations", "unit", scene.data.unit);
  file.write_attribute("/demonstrations", "frame", scene.config.data.frame_name);
  const bool moved = scene.frame && scene.frame->moves_demonstrations();
  for (std::size_t k = 0; k < scene.data.demonstrations.size(); ++k) {
    const Demonstration& d = scene.data.demonstrations[k];
    const std::string group = fmt::format("/demonstrations/{}", k);
    Points position = d.position;
    // As training sees it.
    if (moved) {
      position.rowwise() +=
          (scene.frame->goal.transpose() - scene.frame->goals.row(static_cast<Eigen::Index>(k)))
              .head(position.cols());
    }
    file.write(group + "/time", Vector(d.time.array() - d.time[0]));
    file.write(group + "/position", position);
    file.write(group + "/speed", Vector(d.velocity.rowwise().norm()));
  }
  const Eigen::Index places = scene.data.dimension();
  if (scene.frame) file.write("/goal", Vector(scene.frame->goal.head(places)));
  if (scene.problem) write_sets(file, scene);
  Points crossings(static_cast<Eigen::Index>(scene.survey.crossings.size()), scene.data.dimension());
  for (Eigen::Index i = 0; i < crossings.rows(); ++i)
    crossings.row(i) = scene.survey.crossings[static_cast<std::size_t>(i)].place.transpose();
  if (crossings.rows() > 0) file.write("/crossings", crossings);
  std::vector<Vector> gaps;
  for (const Clearance& c : scene.clearances)
    if (c.at.size() > 0 && c.inside == 0) gaps.insert(gaps.end(), {c.at, c.in_region});
  Points ends(static_cast<Eigen::Index>(gaps.size()), places);
  for (Eigen::Index i = 0; i < ends.rows(); ++i)
    ends.row(i) = gaps[static_cast<std::size_t>(i)].head(places).transpose();
  if (ends.rows() > 0) file.write("/clearances", ends);  // [2 K, n]: from, to
  file.commit();
}

}  // namespace s2nnds
