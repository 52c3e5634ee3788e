// SPDX-License-Identifier: BSD-3-Clause
#include "run_json.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "drawing.h"
#include "s2nnds/runs/motion_report.h"
#include "s2nnds/runs/prepared_run.h"
#include "s2nnds/runs/statement.h"
#include "s2nnds/runs/user_units.h"

namespace s2nnds::studio {
namespace {

using nlohmann::ordered_json;

constexpr Eigen::Index kMostSamples = 400;         // of a demonstration, shown
constexpr Eigen::Index kMostPoints = 600;          // counterexamples of a kind, the last ones
constexpr std::size_t kMostBoxes = 2000;           // open boxes of a condition
constexpr Eigen::Index kGrid2 = 161, kGrid3 = 33;  // points a side of the sets' levels

static_assert(std::endian::native == std::endian::little, "arrays are sent as they lie in memory");

std::string base64(const unsigned char* bytes, std::size_t count) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((count + 2) / 3 * 4);
  for (std::size_t i = 0; i < count; i += 3) {
    std::uint32_t three = static_cast<std::uint32_t>(bytes[i]) << 16;
    if (i + 1 < count) three |= static_cast<std::uint32_t>(bytes[i + 1]) << 8;
    if (i + 2 < count) three |= bytes[i + 2];
    text += digits[three >> 18];
    text += digits[three >> 12 & 63];
    text += i + 1 < count ? digits[three >> 6 & 63] : '=';
    text += i + 2 < count ? digits[three & 63] : '=';
  }
  return text;
}

template <typename T>
ordered_json packed(const std::vector<Eigen::Index>& shape, const std::vector<T>& values) {
  return {{"shape", shape},
          {sizeof(T) == 8 ? "f64" : "f32",
           base64(reinterpret_cast<const unsigned char*>(values.data()), values.size() * sizeof(T))}};
}

ordered_json packed(const Points& values) {  // rows one after another
  std::vector<double> all;
  all.reserve(static_cast<std::size_t>(values.size()));
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    for (Eigen::Index j = 0; j < values.cols(); ++j) all.push_back(values(i, j));
  return packed<double>({values.rows(), values.cols()}, all);
}

std::vector<double> list(const Vector& values) { return {values.begin(), values.end()}; }

ordered_json real(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr); }

ordered_json network_json(const NetworkWeights& network) {
  ordered_json json = {
      {"head", to_string(network.head)}, {"quadratic", network.quadratic}, {"layers", ordered_json::array()}};
  for (const Layer& layer : network.layers) {
    const std::vector<double> bias = list(layer.bias);
    json["layers"].push_back({{"weight", packed(layer.weight)},
                              {"bias", packed<double>({layer.bias.size()}, bias)},
                              {"activation", to_string(layer.activation)}});
  }
  return json;
}

// At most kMostSamples of its rows, the first and the last among them.
Points thinned(const Points& rows) {
  const Eigen::Index count = std::min(rows.rows(), kMostSamples);
  if (count == rows.rows()) return rows;
  Points some(count, rows.cols());
  for (Eigen::Index i = 0; i < count; ++i) some.row(i) = rows.row(i * (rows.rows() - 1) / (count - 1));
  return some;
}

ordered_json demonstrations_json(const RunData& data) {
  ordered_json all = ordered_json::array();
  const Frame& frame = data.frame;
  for (std::size_t k = 0; k < data.demonstrations.size(); ++k) {
    const Demonstration& d = data.demonstrations[k];
    Points position = d.position;  // as training sees it
    position.rowwise() += frame.goal.transpose() - frame.goals.row(static_cast<Eigen::Index>(k));
    const auto& held = data.split.train;
    const bool trains = std::find(held.begin(), held.end(), static_cast<std::int64_t>(k)) != held.end();
    all.push_back({{"position", packed(thinned(position))},
                   {"seconds", d.time[d.time.size() - 1] - d.time[0]},
                   {"trains", trains}});
  }
  return all;
}

// Levels of the sets at a grid over the workspace, normalised, the last axis running fastest.
ordered_json levels_json(const SafetyProblem& problem) {
  const Eigen::Index n = problem.dimension();
  if (n > 3) return nullptr;
  const Eigen::Index side = n == 2 ? kGrid2 : kGrid3;
  const Eigen::Index count = n == 2 ? side * side : side * side * side;
  Points points(count, n);
  for (Eigen::Index k = 0; k < count; ++k) {
    Eigen::Index rest = k;
    for (Eigen::Index i = n; i-- > 0; rest /= side) {
      const double share = static_cast<double>(rest % side) / static_cast<double>(side - 1);
      points(k, i) =
          problem.workspace.lower[i] + share * (problem.workspace.upper[i] - problem.workspace.lower[i]);
    }
  }
  const auto level = [&](const Region& region) {
    std::vector<float> values;
    for (const double value : region.level(points))
      values.push_back(static_cast<float>(std::clamp(value, -1e6, 1e6)));
    return packed<float>(std::vector<Eigen::Index>(static_cast<std::size_t>(n), side), values);
  };
  return {{"side", side}, {"unsafe", level(*problem.unsafe)}, {"initial", level(*problem.initial)}};
}

ordered_json certificate_json(const RunRecord& record) {
  const Certificate& c = record.certificate;
  const Frame& frame = record.data.frame;
  ordered_json json = {{"guarantee", to_string(c.guarantee)},
                       {"sentence", guarantee_sentence(record)},
                       {"statement", c.statement},
                       {"weight_hash", weight_hash(record.networks)},
                       {"level_band", record.problem.level_band},
                       {"disturbance_margin", real(frame.velocity_scale * c.disturbance_margin)},
                       {"barrier_error", c.barrier_float64_error},
                       {"conditions", ordered_json::array()}};
  for (const ConditionVerdict& v : c.conditions) {
    ordered_json one = {{"condition", to_string(v.condition)},
                        {"method", to_string(v.method)},
                        {"verdict", to_string(v.verdict)},
                        {"boxes", v.boxes},
                        {"samples", v.samples},
                        {"witness", nullptr}};
    if (!v.witness.empty()) {
      const Vector z = Eigen::Map<const Vector>(v.witness.data(), std::ssize(v.witness));
      one["witness"] = list(frame.to_data(z));
    }
    json["conditions"].push_back(std::move(one));
  }
  return json;
}

ordered_json counterexamples_json(const RunRecord& record) {
  ordered_json json = ordered_json::object();
  if (!record.checkpoint) return json;
  for (const auto& [name, points] : record.checkpoint->points) {
    if (!name.starts_with("pool_") || points.cols() != record.data.dimension) continue;
    json[name.substr(5)] = packed(Points(points.bottomRows(std::min(points.rows(), kMostPoints))));
  }
  return json;
}

ordered_json open_boxes_json(const RunRecord& record) {
  ordered_json all = ordered_json::array();
  const Frame& frame = record.data.frame;
  const Eigen::Index n = record.data.dimension;
  for (const auto& [condition, boxes] : record.open_boxes) {
    for (Eigen::Index k = 0; k < boxes.rows() && all.size() < kMostBoxes; ++k) {
      all.push_back({list(frame.to_data(Vector(boxes.row(k).head(n).transpose()))),
                     list(frame.to_data(Vector(boxes.row(k).tail(n).transpose())))});
    }
  }
  return all;
}

}  // namespace

ordered_json run_json(const RunRecord& record) {
  check(!record.networks.is_projected(),
        "{}: found a projected f, which the page does not know; expected networks.f.form = plain",
        record.name);
  const PreparedRun setup = prepare(record);
  const Frame& frame = record.data.frame;
  const EvaluationSummary& e = record.evaluation;
  const double volume = std::pow(frame.position_scale, static_cast<double>(frame.places()));
  const bool in_data =
      setup.config.problem.frame == "data" && !frame.has_phase();  // else their levels are shown
  ordered_json json = {
      {"name", record.name},
      {"seed", record.seed},
      {"created", record.created},
      {"version", record.program_version},
      {"dimension", record.data.dimension},
      {"frame",
       {{"unit", frame.unit},
        {"name", frame.name},
        {"goal", list(frame.goal)},
        {"position_scale", frame.position_scale},
        {"velocity_scale", frame.velocity_scale},
        {"moved", frame.moves_demonstrations()}}},
      {"workspace",
       {{"lower", list(frame.to_data(record.problem.workspace.lower))},
        {"upper", list(frame.to_data(record.problem.workspace.upper))}}},
      {"networks",
       {{"f", network_json(record.networks.f)},
        {"V", network_json(record.networks.V)},
        {"B", network_json(record.networks.B)}}},
      {"demonstrations", demonstrations_json(record.data)},
      {"obstacles", in_data ? obstacles_json(setup.config.problem.unsafe) : ordered_json(nullptr)},
      {"initial", in_data ? shape_json(setup.problem.written_initial) : ordered_json(nullptr)},
      {"remarks", record.remarks},
      {"follows", follows_demonstrations(record)},
      {"unsafe_in_words", record.problem.unsafe},
      {"initial_in_words", record.problem.initial},
      {"levels", levels_json(setup.problem)},
      {"counterexamples", counterexamples_json(record)},
      {"open_boxes", open_boxes_json(record)},
      {"certificate", certificate_json(record)},
      {"history", ordered_json::object()},
      {"rounds", record.checkpoint ? record.checkpoint->round : 0},
      {"finished", record.checkpoint ? record.checkpoint->finished : true},
      {"seconds", real(record.timing.training)},
      {"proof_seconds", real(record.timing.proof)},
      {"velocity_rms", real(frame.velocity_scale * std::sqrt(e.mse_train))},
      {"dtw", real(frame.position_scale * e.dtw_train)},
      {"safe_area", real(volume * e.safe_area)},
      {"safe_area_ratio", real(e.safe_area_ratio)}};
  for (const auto& [name, column] : record.history) {
    ordered_json values = ordered_json::array();
    for (const double value : column) values.push_back(real(value));
    json["history"][name] = std::move(values);
  }
  return json;
}

}  // namespace s2nnds::studio
