// SPDX-License-Identifier: BSD-3-Clause
#include "scene_commands.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "new_config_text.h"
#include "progress.h"
#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/hdf5.h"
#include "s2nnds/core/json_text.h"
#include "s2nnds/core/python_module.h"
#include "s2nnds/core/toml_text.h"
#include "s2nnds/data/orientation.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/runs/scene.h"
#include "writable.h"

namespace s2nnds::program {
namespace {

namespace fs = std::filesystem;

std::string sibling(const std::string& path, const std::string& suffix) {
  return fs::path(path).replace_extension().string() + suffix;
}

// ---- what was found, in words

std::string range_text(const Vector& values, const std::string& unit) {
  const double low = values.minCoeff(), high = values.maxCoeff();
  const std::string text =
      high <= 1.005 * low ? fmt::format("{:.3g}", high) : fmt::format("{:.3g} to {:.3g}", low, high);
  return text + (unit.empty() ? "" : " ") + unit;
}

std::string row(const char* name, const std::string& text) {
  return fmt::format("  {:<11} {}\n", name, text);
}

std::string found_text(const Scene& scene, const std::string& unit_note) {
  const Survey& s = scene.survey;
  const std::string& unit = scene.data.unit;
  const std::string per_second = (unit.empty() ? "1" : unit) + "/s";
  const auto length = [&](double value) {
    if (value < 1e-9 * s.extent) value = 0;  // rounding
    return fmt::format("{:.3g}{}{}", value, unit.empty() ? "" : " ", unit);
  };
  std::string text = fmt::format("{}: {} demonstration(s) in {} dimensions\n", scene.config.name,
                                 scene.data.demonstrations.size(), scene.data.dimension());
  for (const std::string& line : scene.data.report) text += row("reading", line);
  text += row("unit", (unit.empty() ? "not known" : unit) + unit_note);
  text += row(
      "box", fmt::format("{} to {}", place_text(s.lower, s.extent, ""), place_text(s.upper, s.extent, unit)));
  text += row("duration", range_text(s.duration, "s"));
  text += row("speed", fmt::format("usually {}, at most {}", range_text(s.usual_speed, per_second),
                                   range_text(s.peak_speed, per_second)));
  const char* recorded = scene.frame && scene.frame->moves_demonstrations() ? ", as recorded" : "";
  text += row("starts", fmt::format("within {} of their mean{}", length(s.start_spread), recorded));
  text += row("ends", fmt::format("within {} of their mean, {:.2g} % of the extent{}", length(s.end_spread),
                                  std::round(1000 * s.end_spread / s.extent) / 10, recorded));
  if (scene.frame && scene.frame->has_orientation()) {
    double most = 0;
    for (const Demonstration& d : scene.data.demonstrations)
      most = std::max(
          most, rotation_vectors(scene.frame->goal_orientation, d.orientation).rowwise().norm().maxCoeff());
    text += row("orientation", fmt::format("quaternions {}, turned by up to {:.0f} degrees from the goal's",
                                           scene.frame->quaternion_order, degrees(most)));
  }
  if (scene.frame) {
    text += row("goal", scene.frame->position_text(scene.frame->goal) +
                            (scene.frame->moves_demonstrations()
                                 ? "; every demonstration is moved to end there, by " +
                                       range_text(scene.frame->end_distances(scene.states), unit)
                                 : ""));
  }
  return text;
}

std::string problems_text(const Scene& scene) {
  std::string text;
  for (const std::string& refusal : scene.refusals) text += row("REFUSED", refusal);
  for (const std::string& warning : scene.warnings) text += row("PROBLEM", warning);
  return text;
}

std::string sets_text(const Scene& scene) {
  if (!scene.problem) return "";
  const Frame& frame = *scene.frame;
  const Box& box = scene.problem->workspace;
  std::string text = row("workspace", fmt::format("{} to {}", frame.position_text(frame.to_data(box.lower)),
                                                  frame.position_text(frame.to_data(box.upper))));
  text += row("initial", scene.problem->initial->describe());
  text += row("obstacle", scene.problem->unsafe->describe());
  const std::vector<std::string> clearances = clearance_texts(scene.clearances, frame);
  for (std::size_t k = 0; k < clearances.size(); ++k)
    text += row(k == 0 ? "clearance" : "", fmt::format("demonstration {}: {}", k, clearances[k]));
  return text;
}

// ---- the figure

// Draws the scene; without matplotlib the command goes on without a figure.
bool draw(const Scene& scene, const std::string& path) {
  const std::string file = path + ".h5";
  save_scene(file, scene);
  bool drawn = false;
  try {
    drawn = run_python_module("figure", "plot_scene", {file, "--out", path}) == 0;
  } catch (const Error& error) {
    spdlog::warn("{}", error.what());
  }
  std::error_code ignored;
  fs::remove(file, ignored);
  if (!drawn) spdlog::warn("{}: not drawn", path);
  return drawn;
}

void print_json(const Scene& scene, const std::string& config, const std::string& figure) {
  nlohmann::ordered_json json = {{"name", scene.config.name},
                                 {"demonstrations", scene.data.demonstrations.size()},
                                 {"dimension", scene.data.dimension()},
                                 {"unit", scene.data.unit},
                                 {"config", config},
                                 {"figure", figure},
                                 {"refusals", scene.refusals},
                                 {"problems", scene.warnings},
                                 {"clearances", nlohmann::ordered_json::array()}};
  for (const Clearance& c : scene.clearances) {
    json["clearances"].push_back(std::isinf(c.distance) ? nlohmann::ordered_json(nullptr)
                                                        : nlohmann::ordered_json(c.distance));
  }
  fmt::print("{}\n", s2nnds::json_text(json));
}

// ---- what files hold

const std::map<std::string, std::string>& sources_by_ending() {
  static const std::map<std::string, std::string> table = {
      {".csv", "csv"}, {".txt", "csv"}, {".tsv", "csv"},   {".dat", "csv"}, {".npy", "npy"},
      {".npz", "npy"}, {".h5", "hdf5"}, {".hdf5", "hdf5"}, {".mat", "mat"}};
  return table;
}

// The reader that a file asks for by its ending: "" for none.
std::string source_of(const fs::path& path) {
  const auto found = sources_by_ending().find(path.extension().string());
  return found == sources_by_ending().end() ? "" : found->second;
}

bool needs_import(const fs::path& path) {
  std::error_code error;
  return path.extension() == ".bag" || path.extension() == ".mcap" ||
         fs::exists(path / "meta/info.json", error) || fs::exists(path / "metadata.yaml", error);
}

// Of a folder the reader that has most files there.
std::string source_in(const fs::path& folder) {
  std::map<std::string, int> counts;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    check(!needs_import(entry.path()),
          "new: found {}; expected it imported first: s2nnds import {} --out recordings.h5",
          entry.path().string(), entry.path().string());
    if (const std::string source = source_of(entry.path()); entry.is_regular_file(error) && !source.empty())
      ++counts[source];
  }
  check(!counts.empty(),
        "new: found no files in {} that can be read; expected CSV, NPY, HDF5 or MATLAB files",
        folder.string());
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

// The one reader of all sources.
std::string source_of_all(const std::vector<std::string>& sources, const std::string& data_dir) {
  std::string one;
  for (const std::string& name : sources) {
    const fs::path path = fs::path(data_dir) / name;
    std::error_code error;
    check(!needs_import(path),
          "new: found {}; expected it imported first: s2nnds import {} --out recordings.h5", name, name);
    const std::string source = fs::is_directory(path, error) ? source_in(path) : source_of(path);
    check(!source.empty(),
          "new: found {}; expected a folder, or CSV (.csv, .txt, .tsv, .dat), NPY (.npy, .npz), HDF5 (.h5, "
          ".hdf5) or MATLAB (.mat) files",
          name);
    check(one.empty() || one == source, "new: found {} and {} files; expected files of one kind", one,
          source);
    one = source;
  }
  return one;
}

// Without --data, paths are written whole, so that the configuration can be used from anywhere.
std::vector<std::string> paths_of(const std::vector<std::string>& sources, const std::string& data_dir) {
  std::vector<std::string> paths;
  for (const std::string& name : sources)
    paths.push_back(data_dir.empty() ? fs::absolute(name).lexically_normal().string() : name);
  return paths;
}

// The files of a folder, or those named, below `data_dir`.
std::vector<std::string> matlab_files(const std::vector<std::string>& paths, const std::string& data_dir) {
  std::vector<std::string> files;
  for (const std::string& name : paths) {
    std::error_code error;
    const fs::path path = fs::path(data_dir) / name;
    if (!fs::is_directory(path, error)) files.push_back(name);
    for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
      if (source_of(entry.path()) == "mat")
        files.push_back((fs::path(name) / entry.path().filename()).string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

// Whether a MATLAB file has all demonstrations of a motion in a published layout: lasa, ds_opt, or "" for
// neither.
std::string layout_of(const std::string& file, const std::string& data_dir) {
  for (const char* const layout : {"lasa", "ds_opt"}) {
    DataOptions data;
    data.source = layout;
    data.file = file;
    try {
      read_demonstrations(data, data_dir);
      return layout;
    } catch (const Error&) {  // another layout
    }
  }
  return "";
}

DataOptions data_options(const NewArguments& arguments, const std::string& data_dir) {
  DataOptions data;
  data.source = source_of_all(arguments.sources, data_dir);
  const std::vector<std::string> paths = paths_of(arguments.sources, data_dir);
  if (data.source == "mat") {
    const std::vector<std::string> files = matlab_files(paths, data_dir);
    if (const std::string layout = files.empty() ? "" : layout_of(files.front(), data_dir); !layout.empty()) {
      check(files.size() == 1,
            "new: found {} MATLAB files, and in {} all demonstrations of a motion (as {} files have them); "
            "expected "
            "one of them alone",
            files.size(), files.front(), layout == "lasa" ? "LASA's" : "ds-opt's");
      data.source = layout;
      data.file = files.front();
      return data;
    }
  }
  data.files = paths;
  data.unit = arguments.unit;
  data.columns.time = arguments.time;
  data.columns.position = arguments.position;
  data.columns.quaternion = arguments.quaternion;
  if (!arguments.quaternion_order.empty()) data.quaternion_order = arguments.quaternion_order;
  data.rate = arguments.rate;
  if (!arguments.time_unit.empty()) data.time_unit = arguments.time_unit;
  return data;
}

// What imported recordings say of their frame: "" without.
std::string frame_name_in(const DataOptions& data, const std::string& data_dir) {
  if (data.source != "hdf5" || data.files.empty()) return "";
  const fs::path path = fs::path(data_dir) / data.files.front();
  if (!fs::is_regular_file(path)) return "";
  const Hdf5Reader file(path.string());
  return file.has_attribute("/demonstrations", "frame") ? file.text_attribute("/demonstrations", "frame")
                                                        : "";
}

// By the size of the motion: no arm's reach is 20 m or half a millimetre. "" where nothing fits.
std::string guess_unit(const Survey& survey, Eigen::Index dimension) {
  if (dimension > 3) return survey.upper.cwiseMax(-survey.lower).maxCoeff() <= 2 * M_PI + 1 ? "rad" : "deg";
  return survey.extent < 0.01 ? "" : survey.extent < 20 ? "m" : survey.extent < 2e4 ? "mm" : "";
}

// The recordings as poses. Where nothing tells the quaternions' order, it is guessed. Throws Error where neither works.
Scene look_at_poses(Config config, const std::string& data_dir, Guesses& guesses) {
  config.data.state = "pose";
  try {
    return look_at(config, data_dir);
  } catch (const Error&) {
    if (config.data.quaternion_order != "auto") throw;
    config.data.quaternion_order = "xyzw";
    Scene scene = look_at(config, data_dir);
    guesses.quaternion_order = true;
    return scene;
  }
}

}  // namespace

int new_config(const NewArguments& arguments, const CommonArguments& common) {
  const std::string data_dir = common.data.empty() ? "" : data_directory(common.data);
  check_writable(arguments.out);
  Config config;
  config.name = fs::path(arguments.out).stem().string();
  config.data = data_options(arguments, data_dir);
  config.data.frame_name = frame_name_in(config.data, data_dir);
  Scene scene = look_at(config, data_dir, print_reading);
  // Orientations beside positions: poses, unless what is told of them cannot be used.
  std::string not_turned;
  Guesses guesses;
  if (scene.data.has_orientations && scene.data.dimension() <= 3) {
    try {
      Scene turned = look_at_poses(config, data_dir, guesses);
      if (turned.frame || !scene.frame) {
        scene = std::move(turned);
      } else {
        not_turned = turned.refusals.front();
      }
    } catch (const Error& error) {
      not_turned = error.what();
    }
  }
  // Where the ends lie apart, there is no one goal: the configuration still trains, and says at what price.
  std::vector<std::string> refusals;
  if (!scene.frame) {
    refusals = scene.refusals;
    scene.config.data.goal = {"each"};
    scene = look_at(Config(scene.config), data_dir);
  }
  std::string unit_note;
  if (scene.data.unit.empty()) {
    scene.data.unit = scene.config.data.unit = guess_unit(scene.survey, scene.data.dimension());
    if (scene.frame) scene.frame->unit = scene.data.unit;
    guesses.unit = !scene.data.unit.empty();
    unit_note = !guesses.unit ? "" : " (guessed from the size of the motion: say --unit if it is another)";
    scene.warnings = warnings_of(scene.survey, scene.data.unit, scene.phase.used);
  }
  scene.warnings.insert(scene.warnings.begin(), refusals.begin(), refusals.end());
  if (!not_turned.empty()) scene.warnings.push_back("orientations are left out: " + not_turned);
  guesses.quaternion_order = guesses.quaternion_order && not_turned.empty();
  if (guesses.quaternion_order)
    scene.warnings.push_back(
        "data.quaternion_order: nothing in the files tells the order of their quaternions, and xyzw is a "
        "guess: in the "
        "wrong one angles stay as they are, and frames do not; say --quaternion-order");
  const std::string figure = sibling(arguments.out, ".png");
  write_atomic_file(arguments.out, new_config_text(scene, guesses, common.data), "configuration");
  fmt::print("{}{}", found_text(scene, unit_note), problems_text(scene));
  const bool drawn = draw(scene, figure);
  const std::string data_flag = common.data.empty() ? "" : " --data " + common.data;
  fmt::print("{} written{}\nnext: put the obstacle in, then\n  s2nnds preview {}{}\n  s2nnds train {}{}\n",
             arguments.out, drawn ? ", drawn in " + figure : "", arguments.out, data_flag, arguments.out,
             data_flag);
  if (common.json) print_json(scene, arguments.out, drawn ? figure : "");
  return kVerified;
}

int preview(const PreviewArguments& arguments, const CommonArguments& common) {
  const std::string text = read_config_text(arguments.config);
  const Config config = parse_config(text, arguments.config, arguments.assignments);
  const std::string figure =
      arguments.out.empty() ? sibling(arguments.config, "-preview.png") : arguments.out;
  check_writable(figure);
  Scene scene = look_at(config, data_directory(common.data), print_reading);
  if (std::string problem = dimension_warning(config, scene.data.dimension()); !problem.empty())
    scene.warnings.push_back(std::move(problem));
  fmt::print("{}{}", found_text(scene, ""), sets_text(scene));
  for (const std::string& warning : scene.warnings) fmt::print("{}", row("PROBLEM", warning));
  if (scene.warnings.empty() && scene.refusals.empty()) fmt::print("{}", row("problems", "none found"));
  const bool drawn = draw(scene, figure);
  if (drawn) fmt::print("drawn in {}\n", figure);
  if (common.json) print_json(scene, arguments.config, drawn ? figure : "");
  if (!scene.refusals.empty()) throw Error(scene.refusals.front());
  return kVerified;
}

}  // namespace s2nnds::program
