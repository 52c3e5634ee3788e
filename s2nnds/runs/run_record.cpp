// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/run_record.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <set>

#include "s2nnds/core/check.h"
#include "s2nnds/core/hdf5.h"
#include "s2nnds/core/printable.h"
#include "s2nnds/runs/hdf5_fields.h"

namespace s2nnds {
namespace {

template <typename T>
using Named = std::vector<std::pair<std::string, T>>;

// ---- What must fit together

// Names of items become links of the file, which a slash would split.
void check_name(const std::string& where, const std::string& name) {
  check(!name.empty() && name != "." && name.find('/') == std::string::npos,
        "{}: found the name \"{}\", expected one without a slash", where, name);
}

void check_data(const RunData& data) {
  check(data.dimension >= 1, "/data: found dimension {}, expected at least 1", data.dimension);
  data.frame.check(data.demonstrations.size(), data.dimension, "/data");
  for (std::size_t k = 0; k < data.demonstrations.size(); ++k) {
    const Demonstration& d = data.demonstrations[k];
    check(d.position.rows() == d.time.size() && d.velocity.rows() == d.time.size() &&
              d.position.cols() == data.dimension && d.velocity.cols() == data.dimension,
          "/data/demonstrations/{}: found position [{}, {}] and velocity [{}, {}], expected [{}, {}]", k,
          d.position.rows(), d.position.cols(), d.velocity.rows(), d.velocity.cols(), d.time.size(),
          data.dimension);
  }
  for (std::size_t k = 0; k < data.demonstrations.size(); ++k) {
    const Demonstration& d = data.demonstrations[k];
    const Eigen::Index rows = data.frame.has_orientation() ? d.time.size() : 0;
    check(d.orientation.rows() == rows && (rows == 0 || d.orientation.cols() == 4),
          "/data/demonstrations/{}: found orientation [{}, {}], expected [{}, 4]", k, d.orientation.rows(),
          d.orientation.cols(), rows);
  }
  const auto count = static_cast<std::int64_t>(data.demonstrations.size());
  for (const auto& [name, indices] :
       {std::pair{"train", &data.split.train}, std::pair{"test", &data.split.test},
        std::pair{"validation", &data.split.validation}}) {
    for (const std::int64_t index : *indices) {
      check(index >= 0 && index < count, "/data/{}: found demonstration {}, expected 0 to {}", name, index,
            count - 1);
    }
  }
}

void check_network(const std::string& name, const NetworkWeights& network, Eigen::Index inputs,
                   Eigen::Index outputs) {
  try {
    network.check();
  } catch (const Error& error) {
    fail("/networks/{}: {}", name, error.what());
  }
  check(network.input_dimension() == inputs && network.output_dimension() == outputs,
        "/networks/{}: found {} inputs and {} outputs, expected {} and {}", name, network.input_dimension(),
        network.output_dimension(), inputs, outputs);
}

void check_grid(const Grid& grid, Eigen::Index dimension) {
  Eigen::Index cells = 1;
  for (const Vector& axis : grid.axes) cells *= axis.size();
  check(static_cast<Eigen::Index>(grid.axes.size()) == dimension, "/grid: found {} axes, expected {}",
        grid.axes.size(), dimension);
  for (const auto& [name, values] : {std::pair{"unsafe", &grid.unsafe}, std::pair{"initial", &grid.initial},
                                     std::pair{"V", &grid.V}, std::pair{"B", &grid.B}}) {
    check(values->size() == cells, "/grid/{}: found {} values, expected {}", name, values->size(), cells);
  }
  check(grid.velocity.rows() == cells && grid.velocity.cols() == dimension,
        "/grid/velocity: found [{}, {}], expected [{}, {}]", grid.velocity.rows(), grid.velocity.cols(),
        cells, dimension);
}

// ---- Sections. Each pair writes and reads one group.

void write(Hdf5Writer& file, const RunConfig& config) {
  file.write("/config/text", config.text);
  file.write("/config/resolved", config.resolved);
  file.make_group("/config/values");
  for (const auto& [key, value] : config.values) file.write_attribute("/config/values", key, value);
}

RunConfig read_config(const Hdf5Reader& file) {
  RunConfig config = {
      .text = file.read_text("/config/text"), .resolved = file.read_text("/config/resolved"), .values = {}};
  for (const std::string& key : file.attributes("/config/values")) {
    config.values.emplace_back(key, file.text_attribute("/config/values", key));
  }
  return config;
}

std::string numbered(const std::string& group, std::size_t index) {
  return fmt::format("{}/{}", group, index);
}

void write(Hdf5Writer& file, const RunData& data) {
  file.write_attribute("/data", "dimension", data.dimension);
  file.write_attribute("/data", "unit", data.frame.unit);
  file.write_attribute("/data", "frame_name", data.frame.name);
  file.write_attribute("/data", "normalization", data.frame.normalization);
  file.write_attribute("/data", "position_scale", data.frame.position_scale);
  file.write_attribute("/data", "velocity_scale", data.frame.velocity_scale);
  file.write("/data/goal", data.frame.goal);
  if (data.frame.has_orientation()) {
    file.write("/data/goal_orientation", data.frame.goal_orientation);
    file.write_attribute("/data", "quaternion_order", data.frame.quaternion_order);
  }
  if (data.frame.has_phase()) file.write_attribute("/data", "phase_start", data.frame.phase_start);
  file.write("/data/goals", data.frame.goals);
  file.write("/data/train", data.split.train);
  file.write("/data/test", data.split.test);
  if (!data.split.validation.empty()) file.write("/data/validation", data.split.validation);
  if (!data.report.empty()) file.write("/data/report", data.report);
  file.make_group("/data/demonstrations");
  for (std::size_t k = 0; k < data.demonstrations.size(); ++k) {
    const std::string group = numbered("/data/demonstrations", k);
    file.write(group + "/time", data.demonstrations[k].time);
    file.write(group + "/position", data.demonstrations[k].position);
    file.write(group + "/velocity", data.demonstrations[k].velocity);
    if (data.demonstrations[k].orientation.size() > 0)
      file.write(group + "/orientation", data.demonstrations[k].orientation);
  }
}

RunData read_data(const Hdf5Reader& file) {
  RunData data;
  data.frame = {.unit = file.text_attribute("/data", "unit"),
                .name = file.text_attribute("/data", "frame_name"),
                .normalization = file.text_attribute("/data", "normalization"),
                .goal = file.read_vector("/data/goal"),
                .goals = file.read_points("/data/goals"),
                .position_scale = file.number_attribute("/data", "position_scale"),
                .velocity_scale = file.number_attribute("/data", "velocity_scale")};
  if (file.exists("/data/goal_orientation")) {
    data.frame.goal_orientation = file.read_vector("/data/goal_orientation");
    data.frame.quaternion_order = file.text_attribute("/data", "quaternion_order");
  }
  if (file.has_attribute("/data", "phase_start"))
    data.frame.phase_start = file.number_attribute("/data", "phase_start");
  data.dimension = file.integer_attribute("/data", "dimension");
  check(data.dimension >= 1, "{}: /data: found dimension {}, expected at least 1", file.path(),
        data.dimension);
  data.split = {.train = file.read_integers("/data/train"), .test = file.read_integers("/data/test")};
  if (file.exists("/data/validation")) data.split.validation = file.read_integers("/data/validation");
  if (file.exists("/data/report")) data.report = file.read_texts("/data/report");
  const std::size_t count = file.children("/data/demonstrations").size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::string group = numbered("/data/demonstrations", k);
    data.demonstrations.push_back({.time = file.read_vector(group + "/time"),
                                   .position = file.read_points(group + "/position"),
                                   .velocity = file.read_points(group + "/velocity")});
    if (file.exists(group + "/orientation"))
      data.demonstrations.back().orientation = file.read_points(group + "/orientation");
  }
  return data;
}

void write(Hdf5Writer& file, const RunProblem& problem) {
  file.write_attribute("/problem", "frame", problem.frame);
  file.write_attribute("/problem", "unsafe", problem.unsafe);
  file.write_attribute("/problem", "initial", problem.initial);
  file.write_attribute("/problem", "containment", problem.containment);
  file.write_attribute("/problem", "level_band", problem.level_band);
  file.write("/problem/workspace_lower", problem.workspace.lower);
  file.write("/problem/workspace_upper", problem.workspace.upper);
  std::size_t count = 0;
  for (const auto& [name, bytes] : problem.files) {
    const std::string item = numbered("/problem/files", count++);
    file.write(item, std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
    file.write_attribute(item, "name", name);  // a path, which HDF5 would take for groups
  }
}

RunProblem read_problem(const Hdf5Reader& file) {
  RunProblem problem;
  problem.frame = file.text_attribute("/problem", "frame");
  problem.unsafe = file.text_attribute("/problem", "unsafe");
  problem.initial = file.text_attribute("/problem", "initial");
  problem.containment = file.number_attribute("/problem", "containment");
  problem.level_band = file.number_attribute("/problem", "level_band");
  problem.workspace = {.lower = file.read_vector("/problem/workspace_lower"),
                       .upper = file.read_vector("/problem/workspace_upper")};
  if (!file.exists("/problem/files")) return problem;
  for (const std::string& child : file.children("/problem/files")) {
    const std::string item = "/problem/files/" + child;
    const std::vector<std::uint8_t> bytes = file.read_bytes(item);
    problem.files[file.text_attribute(item, "name")] = std::string(bytes.begin(), bytes.end());
  }
  return problem;
}

void write_network(Hdf5Writer& file, const std::string& group, const NetworkWeights& network) {
  file.write_attribute(group, "head", std::string(to_string(network.head)));
  file.write_attribute(group, "quadratic", network.quadratic);
  file.write_attribute(group, "layers", static_cast<std::int64_t>(network.layers.size()));
  for (std::size_t k = 0; k < network.layers.size(); ++k) {
    const Layer& layer = network.layers[k];
    file.write_attribute(group, fmt::format("activation_{}", k), std::string(to_string(layer.activation)));
    file.write(fmt::format("{}/weight_{}", group, k), layer.weight);
    if (layer.bias.size() > 0) file.write(fmt::format("{}/bias_{}", group, k), layer.bias);
  }
}

// f, V and how they move together.
void write_motion(Hdf5Writer& file, const Networks& networks) {
  write_network(file, "/networks/f", networks.f);
  write_network(file, "/networks/V", networks.V);
  if (networks.is_projected()) file.write_attribute("/networks/f", "decay", networks.decay);
}

double read_decay(const Hdf5Reader& file) {
  return file.has_attribute("/networks/f", "decay") ? file.number_attribute("/networks/f", "decay") : 0.0;
}

NetworkWeights read_network(const Hdf5Reader& file, const std::string& group) {
  NetworkWeights network;
  network.quadratic = file.number_attribute(group, "quadratic");
  const std::int64_t layers = file.integer_attribute(group, "layers");
  try {
    network.head = head_from(file.text_attribute(group, "head"));
    for (std::int64_t k = 0; k < layers; ++k) {
      Layer layer;
      layer.activation = activation_from(file.text_attribute(group, fmt::format("activation_{}", k)));
      layer.weight = file.read_points(fmt::format("{}/weight_{}", group, k));
      const std::string bias = fmt::format("{}/bias_{}", group, k);
      if (file.exists(bias)) layer.bias = file.read_vector(bias);
      network.layers.push_back(std::move(layer));
    }
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.starts_with(file.path())) throw;
    fail("{}: {}: {}", file.path(), group, message);
  }
  return network;
}

void write(Hdf5Writer& file, const OrientationLaw& law) {
  write_network(file, "/networks/psi", law.psi);
  file.write_attribute("/networks/psi", "rate", law.rate);
  file.write_attribute("/networks/psi", "initial_error", law.initial_error);
}

OrientationLaw read_orientation(const Hdf5Reader& file) {
  return {.psi = read_network(file, "/networks/psi"),
          .rate = file.number_attribute("/networks/psi", "rate"),
          .initial_error = file.number_attribute("/networks/psi", "initial_error")};
}

Named<Vector> read_history(const Hdf5Reader& file) {
  Named<Vector> columns;
  for (const std::string& name : file.children("/history")) {
    columns.emplace_back(name, file.read_vector("/history/" + name));
  }
  return columns;
}

Named<double> read_numbers(const Hdf5Reader& file, const std::string& group,
                           const std::set<std::string>& others = {}) {
  Named<double> numbers;
  for (const std::string& name : file.attributes(group)) {
    if (!others.contains(name)) numbers.emplace_back(name, file.number_attribute(group, name));
  }
  return numbers;
}

void write_numbers(Hdf5Writer& file, const std::string& group, const Named<double>& numbers) {
  file.make_group(group);
  for (const auto& [name, value] : numbers) file.write_attribute(group, name, value);
}

void write(Hdf5Writer& file, const std::vector<StoredRollout>& rollouts) {
  file.make_group("/rollouts");
  for (std::size_t k = 0; k < rollouts.size(); ++k) {
    const std::string group = numbered("/rollouts", k);
    file.write_attribute(group, "start_kind", rollouts[k].start_kind);
    file.write_attribute(group, "stop", rollouts[k].stop);
    file.write(group + "/time", rollouts[k].time);
    file.write(group + "/position", rollouts[k].position);
    if (rollouts[k].orientation.size() > 0) file.write(group + "/orientation", rollouts[k].orientation);
  }
}

std::vector<StoredRollout> read_rollouts(const Hdf5Reader& file) {
  std::vector<StoredRollout> rollouts;
  const std::size_t count = file.children("/rollouts").size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::string group = numbered("/rollouts", k);
    rollouts.push_back({.start_kind = file.text_attribute(group, "start_kind"),
                        .stop = file.text_attribute(group, "stop"),
                        .time = file.read_vector(group + "/time"),
                        .position = file.read_points(group + "/position")});
    if (file.exists(group + "/orientation"))
      rollouts.back().orientation = file.read_points(group + "/orientation");
  }
  return rollouts;
}

void write(Hdf5Writer& file, const Grid& grid) {
  std::vector<Eigen::Index> shape;
  for (std::size_t k = 0; k < grid.axes.size(); ++k) {
    file.write(fmt::format("/grid/axis_{}", k), grid.axes[k]);
    shape.push_back(grid.axes[k].size());
  }
  for (const auto& [name, values] : {std::pair{"unsafe", &grid.unsafe}, std::pair{"initial", &grid.initial},
                                     std::pair{"V", &grid.V}, std::pair{"B", &grid.B}}) {
    file.write(fmt::format("/grid/{}", name), Array{shape, {values->begin(), values->end()}});
  }
  shape.push_back(grid.velocity.cols());
  file.write("/grid/velocity",
             Array{shape, {grid.velocity.data(), grid.velocity.data() + grid.velocity.size()}});
}

Grid read_grid(const Hdf5Reader& file, Eigen::Index dimension) {
  Grid grid;
  std::vector<Eigen::Index> shape;
  for (Eigen::Index k = 0; k < dimension; ++k) {
    grid.axes.push_back(file.read_vector(fmt::format("/grid/axis_{}", k)));
    shape.push_back(grid.axes.back().size());
  }
  const auto read = [&file](const std::string& item, const std::vector<Eigen::Index>& expected) {
    const Array array = file.read_array(item);
    check(array.shape == expected, "{}: {}: found the shape [{}], expected [{}]", file.path(), item,
          fmt::join(array.shape, ", "), fmt::join(expected, ", "));
    return Vector(
        Eigen::Map<const Vector>(array.values.data(), static_cast<Eigen::Index>(array.values.size())));
  };
  grid.unsafe = read("/grid/unsafe", shape);
  grid.initial = read("/grid/initial", shape);
  grid.V = read("/grid/V", shape);
  grid.B = read("/grid/B", shape);
  shape.push_back(dimension);
  const Vector velocity = read("/grid/velocity", shape);
  grid.velocity = Eigen::Map<const Points>(velocity.data(), velocity.size() / dimension, dimension);
  return grid;
}

void write(Hdf5Writer& file, const Checkpoint& checkpoint) {
  file.write_attribute("/checkpoint", "round", checkpoint.round);
  file.write_attribute("/checkpoint", "finished", std::int64_t{checkpoint.finished});
  file.make_group("/checkpoint/points");
  for (const auto& [name, points] : checkpoint.points) file.write("/checkpoint/points/" + name, points);
  write_numbers(file, "/checkpoint", checkpoint.numbers);
}

Checkpoint read_checkpoint(const Hdf5Reader& file) {
  Checkpoint checkpoint;
  checkpoint.round = file.integer_attribute("/checkpoint", "round");
  checkpoint.finished = file.integer_attribute("/checkpoint", "finished") != 0;
  for (const std::string& name : file.children("/checkpoint/points")) {
    checkpoint.points.emplace_back(name, file.read_points("/checkpoint/points/" + name));
  }
  checkpoint.numbers = read_numbers(file, "/checkpoint", {"round", "finished"});
  return checkpoint;
}

void check_schema(const Hdf5Reader& file) {
  check(file.has_attribute("/", "schema_version"),
        "{}: expected a run file, found HDF5 without a schema_version", file.path());
  const std::int64_t schema = file.integer_attribute("/", "schema_version");
  check(schema == run_schema_version, "{}: found a run file of schema {}, expected schema {}", file.path(),
        schema, run_schema_version);
}

// check_record with the file's name in its message.
void check_record_of(const std::string& path, const RunRecord& record) {
  try {
    check_record(record);
  } catch (const Error& error) {
    fail("{}: {}", path, error.what());
  }
}

RunRecord read_run(const std::string& path) {
  const Hdf5Reader file(path);
  check_schema(file);
  RunRecord record;
  record.program_version = file.text_attribute("/", "program_version");
  record.library_versions = file.text_attribute("/", "library_versions");
  record.created = file.text_attribute("/", "created");
  record.name = file.text_attribute("/", "name");
  record.seed = file.integer_attribute("/", "seed");
  record.config = read_config(file);
  record.data = read_data(file);
  record.problem = read_problem(file);
  record.history = read_history(file);
  record.networks = {.f = read_network(file, "/networks/f"),
                     .V = read_network(file, "/networks/V"),
                     .B = read_network(file, "/networks/B"),
                     .decay = read_decay(file)};
  if (file.exists("/networks/psi")) record.orientation = read_orientation(file);
  record.certificate = read_fields<Certificate>(file, "/certificate");
  if (file.exists("/certificate/open_boxes")) {
    for (const std::string& name : file.children("/certificate/open_boxes")) {
      record.open_boxes.emplace_back(name, file.read_points("/certificate/open_boxes/" + name));
    }
  }
  if (file.exists("/certificate/pushes")) record.pushes = file.read_points("/certificate/pushes");
  record.evaluation = read_fields<EvaluationSummary>(file, "/evaluation");
  if (file.exists("/remarks")) record.remarks = file.read_texts("/remarks");
  record.timing = read_fields<RunTiming>(file, "/timing");
  record.rollouts = read_rollouts(file);
  if (file.exists("/grid")) record.grid = read_grid(file, record.data.dimension);
  if (file.exists("/checkpoint")) record.checkpoint = read_checkpoint(file);
  check_record_of(path, record);
  return record;
}

}  // namespace

void EvaluationSummary::visit(FieldVisitor& v) {
  v.field("mse_train", mse_train, any_number());
  v.field("mse_test", mse_test, any_number());
  v.field("mse_validation", mse_validation, any_number());
  v.field("sd_train", sd_train, any_number());
  v.field("sd_test", sd_test, any_number());
  v.field("dtw_train", dtw_train, any_number());
  v.field("dtw_test", dtw_test, any_number());
  v.field("dtw_independent_test", dtw_independent_test, any_number());
  v.field("deviation_mean", deviation_mean, any_number());
  v.field("deviation_largest", deviation_largest, any_number());
  v.field("not_followed", not_followed, any_number());
  v.field("starts_not_followed", starts_not_followed, any_number());
  v.field("orientation_mean_train", orientation_mean_train, any_number());
  v.field("orientation_largest_train", orientation_largest_train, any_number());
  v.field("orientation_mean_test", orientation_mean_test, any_number());
  v.field("orientation_largest_test", orientation_largest_test, any_number());
  v.field("safe_area", safe_area, any_number());
  v.field("true_safe_area", true_safe_area, any_number());
  v.field("safe_area_ratio", safe_area_ratio, any_number());
}

void RunTiming::visit(FieldVisitor& v) {
  v.field("training", training, any_number());
  v.field("first_clean_round", first_clean_round, any_number());
  v.field("verification_sampled", verification_sampled, any_number());
  v.field("verification_conformal", verification_conformal, any_number());
  v.field("verification_proof", verification_proof, any_number());
  v.field("proof", proof, any_number());
  v.field("disturbance_margin", disturbance_margin, any_number());
  v.field("execution", execution, any_number());
  v.field("evaluation", evaluation, any_number());
}

std::string time_stamp() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

void check_record(const RunRecord& record) {
  check_data(record.data);
  const Eigen::Index n = record.data.dimension;
  check(record.problem.workspace.lower.size() == n && record.problem.workspace.upper.size() == n,
        "/problem: found workspace_lower [{}] and workspace_upper [{}], expected [{}]",
        record.problem.workspace.lower.size(), record.problem.workspace.upper.size(), n);
  for (const auto& [name, column] : record.history) {
    check_name("/history", name);
    check(column.size() == record.history.front().second.size(),
          "/history/{}: found {} rounds, expected {} as in {}", name, column.size(),
          record.history.front().second.size(), record.history.front().first);
  }
  check_network("f", record.networks.f, n, n);
  check_network("V", record.networks.V, n, 1);
  check(record.networks.decay >= 0.0 && std::isfinite(record.networks.decay),
        "/networks/f: found decay {}, expected a number >= 0", record.networks.decay);
  check_network("B", record.networks.B, n, 1);
  if (record.orientation) {
    check(record.data.frame.has_orientation(),
          "/networks/psi: found an orientation law, but no orientations in /data");
    try {
      record.orientation->check(n);
    } catch (const Error& error) {
      fail("/networks/psi: {}", error.what());
    }
  }
  for (std::size_t k = 0; k < record.rollouts.size(); ++k) {
    const StoredRollout& rollout = record.rollouts[k];
    check(rollout.position.rows() == rollout.time.size() && rollout.position.cols() == n,
          "/rollouts/{}: found position [{}, {}], expected [{}, {}]", k, rollout.position.rows(),
          rollout.position.cols(), rollout.time.size(), n);
    check(rollout.orientation.size() == 0 ||
              (rollout.orientation.rows() == rollout.time.size() && rollout.orientation.cols() == 4),
          "/rollouts/{}: found orientation [{}, {}], expected [{}, 4]", k, rollout.orientation.rows(),
          rollout.orientation.cols(), rollout.time.size());
  }
  for (std::size_t k = 0; k < record.certificate.conditions.size(); ++k) {
    const auto size = std::ssize(record.certificate.conditions[k].witness);
    check(size == 0 || size == n,
          "/certificate/conditions/{}: found a witness of {} coordinates, expected {}", k, size, n);
  }
  for (const auto& [name, corners] : record.open_boxes) {
    check(corners.cols() == 2 * n, "/certificate/open_boxes/{}: found {} columns, expected {}", name,
          corners.cols(), 2 * n);
  }
  check(record.pushes.size() == 0 || record.pushes.cols() == n + 1,
        "/certificate/pushes: found {} columns, expected {}", record.pushes.cols(), n + 1);
  if (record.grid) check_grid(*record.grid, n);
  if (record.checkpoint) {
    for (const auto& [name, points] : record.checkpoint->points) check_name("/checkpoint/points", name);
  }
}

void save_run(const std::string& path, const RunRecord& record) {
  check_record_of(path, record);
  Hdf5Writer file(path);
  file.write_attribute("/", "schema_version", run_schema_version);
  file.write_attribute("/", "program_version", record.program_version);
  file.write_attribute("/", "library_versions", record.library_versions);
  file.write_attribute("/", "created", record.created);
  file.write_attribute("/", "name", record.name);
  file.write_attribute("/", "seed", record.seed);
  write(file, record.config);
  write(file, record.data);
  write(file, record.problem);
  file.make_group("/history");
  for (const auto& [name, column] : record.history) file.write("/history/" + name, column);
  write_motion(file, record.networks);
  write_network(file, "/networks/B", record.networks.B);
  if (record.orientation) write(file, *record.orientation);
  write_fields(file, "/certificate", record.certificate);
  for (const auto& [name, corners] : record.open_boxes)
    file.write("/certificate/open_boxes/" + name, corners);
  if (record.pushes.size() > 0) file.write("/certificate/pushes", record.pushes);
  write_fields(file, "/evaluation", record.evaluation);
  if (!record.remarks.empty()) file.write("/remarks", record.remarks);
  write_fields(file, "/timing", record.timing);
  write(file, record.rollouts);
  if (record.grid) write(file, *record.grid);
  if (record.checkpoint) write(file, *record.checkpoint);
  file.commit();
}

void save_proof(const std::string& path, const RunRecord& record, const ProofCovers& covers) {
  check_record_of(path, record);
  Hdf5Writer file(path);
  file.write_attribute("/", "program_version", record.program_version);
  file.write_attribute("/", "name", record.name);
  file.write_attribute("/data", "dimension", record.data.dimension);
  write_motion(file, record.networks);
  write_network(file, "/networks/B", record.networks.B);
  file.write_attribute("/certificate", "scope", record.certificate.scope);
  for (const auto& [name, bytes] : covers) file.write("/cover/" + name, bytes);
  file.commit();
}

RunRecord load_run(const std::string& path) {
  try {
    return read_run(path);
  } catch (const Error& error) {
    throw Error(printable(error.what()));  // names and words of the file stand in it
  }
}

}  // namespace s2nnds
