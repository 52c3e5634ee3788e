// SPDX-License-Identifier: BSD-3-Clause
#include "new_config_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "s2nnds/core/toml_text.h"
#include "s2nnds/runs/version.h"

namespace s2nnds::program {
namespace {

// A line, and what there is to say about it.
std::string line(const std::string& setting, const std::string& comment = "") {
  return comment.empty() ? setting + "\n" : fmt::format("{:<46} # {}\n", setting, comment);
}

std::string setting(const char* key, const std::string& value) { return fmt::format("{} = {}", key, value); }

// Numbers rounded to what is worth reading: a hundredth of the extent.
std::string point(const Vector& place, double extent) {
  const double digits = std::pow(10.0, 2 - std::floor(std::log10(extent)));
  std::vector<double> rounded;
  for (const double coordinate : place) rounded.push_back(std::round(coordinate * digits) / digits + 0.0);
  return fmt::format("[{:.6g}]", fmt::join(rounded, ", "));
}

// Where training sees a demonstration: moved, where each is.
Points as_trained(const Scene& scene, std::size_t k) {
  Points position = scene.data.demonstrations[k].position;
  if (scene.frame) {
    position.rowwise() +=
        (scene.frame->goal.transpose() - scene.frame->goals.row(static_cast<Eigen::Index>(k)))
            .head(position.cols());
  }
  return position;
}

// The box around all of them.
Box box_of(const Scene& scene) {
  Box box{scene.survey.upper, scene.survey.lower};
  for (std::size_t k = 0; k < scene.data.demonstrations.size(); ++k) {
    const Points position = as_trained(scene, k);
    box.lower = box.lower.cwiseMin(position.colwise().minCoeff().transpose());
    box.upper = box.upper.cwiseMax(position.colwise().maxCoeff().transpose());
  }
  return box;
}

std::string data_section(const Scene& scene, const Guesses& guesses, const std::string& data_flag) {
  const DataOptions& data = scene.config.data;
  std::string text = "[data]\n" + line(setting("source", toml_text(data.source)));
  if (data.files.empty()) {
    text += line(setting("file", toml_text(data.file)));
  } else {
    text += line(setting("files", toml_text(data.files)),
                 data_flag.empty() ? "files, folders or patterns" : "below --data " + data_flag);
  }
  std::vector<std::string> columns;
  if (!data.columns.time.empty()) columns.push_back(setting("time", toml_text(data.columns.time)));
  if (!data.columns.position.empty())
    columns.push_back(setting("position", toml_text(data.columns.position)));
  if (!data.columns.quaternion.empty() && data.state == "pose")
    columns.push_back(setting("quaternion", toml_text(data.columns.quaternion)));
  if (!columns.empty()) text += line(fmt::format("columns = {{ {} }}", fmt::join(columns, ", ")));
  if (data.state == "pose") {
    text += line(setting("state", toml_text(data.state)),
                 "positions with orientations; or position, without them");
    text += line(setting("quaternion_order", toml_text(scene.data.quaternion_order)),
                 guesses.quaternion_order ? "a guess: nothing in the files tells it" : "");
  }
  if (scene.phase.used) {
    text += line(setting("state", toml_text(std::string("phase"))),
                 "states (x, s): the motion crosses itself or ends where it starts");
  }
  if (data.time_unit != "auto") text += line(setting("time_unit", toml_text(data.time_unit)));
  if (data.rate > 0) text += line(setting("rate", toml_text(data.rate)), "samples per second");
  if (!data.files.empty()) {
    text += line(
        setting("unit", toml_text(scene.data.unit)),
        guesses.unit ? "guessed from the size of the motion: check it" : "of all coordinates in this file");
  }
  if (!data.frame_name.empty()) text += line(setting("frame_name", toml_text(data.frame_name)));
  const Survey& s = scene.survey;
  if (data.goal.word == "each") {
    text +=
        line(setting("goal", toml_text(std::string("each"))),
             fmt::format(
                 "the ends lie up to {:.3g} {} from their mean: every demonstration is MOVED to end there.",
                 s.end_spread, scene.data.unit));
    text += line("# If they show different goals, use those of one goal: use = [0, 1]; or name it: goal = " +
                 point(scene.data.demonstrations.front().position.bottomRows(1).transpose(), s.extent));
  } else {
    text += line(
        setting("goal", toml_text(std::string("mean"))),
        fmt::format("of the ends, here {}; or a point",
                    place_text(scene.frame->goal.head(scene.data.dimension()), s.extent, scene.data.unit)));
  }
  const std::size_t count = scene.data.demonstrations.size();
  text += line(count < 4 ? "test = []" : "test = [-1]",
               count < 4 ? "none held out: there are few" : "the last fifth is held out, to measure errors");
  return text;
}

std::string problem_section(const Scene& scene) {
  const Survey& s = scene.survey;
  const std::string& unit = scene.data.unit;
  const Box box = box_of(scene);
  const Vector middle = box.center();
  const double tenth = 0.1 * s.extent;
  const std::string aside = point((middle.array() + 0.3 * s.extent).matrix(), s.extent);
  std::string text = "[problem]\n";
  text += line("# All in " + (unit.empty() ? std::string("the unit of the recordings") : unit) +
               ", in the frame of the recordings. The obstacle, none yet; for example one of");
  text += line(fmt::format("# unsafe = {{ type = \"ball\", center = {}, radius = {:.2g} }}", aside, tenth));
  text += line(fmt::format("# unsafe = {{ type = \"box\", lower = {}, upper = {}, inflate = {:.2g} }}",
                           point((middle.array() + 0.2 * s.extent).matrix(), s.extent),
                           point((middle.array() + 0.4 * s.extent).matrix(), s.extent), 0.2 * tenth));
  if (scene.data.dimension() == 2)
    text += line("# unsafe = { type = \"occupancy_image\", file = \"map.yaml\", inflate = 0.1 }");
  if (scene.data.dimension() == 3)
    text += line("# unsafe = { type = \"mesh\", file = \"table.stl\", scale = 1.0 }");
  text += line("# inflate grows it by the size of what moves; experiments/configs/README.md has every kind.");
  text += line("unsafe = { type = \"none\" }");
  text += line("# Starts: the box around the demonstrations' starts, a little larger. Or name it:");
  text += line(fmt::format("# initial = {{ type = \"ball\", center = {}, radius = {:.2g} }}",
                           point(as_trained(scene, 0).row(0).transpose(), s.extent), tenth));
  text += line(
      "# Nothing is claimed outside of the workspace: 1.25 times the largest distance from the goal on every "
      "side, or");
  const Vector margin = Vector::Constant(s.lower.size(), 0.25 * s.extent);
  text += line(fmt::format("# bounds = {{ lower = {}, upper = {} }}", point(box.lower - margin, s.extent),
                           point(box.upper + margin, s.extent)));
  return text;
}

}  // namespace

std::string new_config_text(const Scene& scene, const Guesses& guesses, const std::string& data_flag) {
  std::string text = fmt::format(
      "# {} demonstration(s), read by s2nnds {}. Trains as it stands; every key: "
      "experiments/configs/README.md\n",
      scene.data.demonstrations.size(), program_version());
  for (const std::string& line : scene.data.report) text += "# " + line + "\n";
  for (const std::string& problem : scene.warnings) text += "# PROBLEM: " + problem + "\n";
  text += setting("name", toml_text(scene.config.name)) + "\n";
  if (scene.data.dimension() + (scene.phase.used ? 1 : 0) == most_proved_dimensions)
    text += line("profile = \"smooth\"", "four dimensions: networks on which a proof ends");
  text += "\n";
  text += data_section(scene, guesses, data_flag) + "\n" + problem_section(scene);
  if (scene.data.dimension() > most_proved_dimensions) {
    text += "\n[verification]\n" + line("method = \"conformal\"",
                                        "a proof covers the whole workspace, too much in so many dimensions");
  }
  return text;
}

}  // namespace s2nnds::program
