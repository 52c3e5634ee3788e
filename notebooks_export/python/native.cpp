// SPDX-License-Identifier: BSD-3-Clause
// The compiled part of the Python package s2nnds: s2nnds._native. Its functions take and return plain values; the
// modules beside it give them their public form. Whatever computes for long lets other Python threads run.

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>

#include "s2nnds/core/check.h"
#include "s2nnds/core/settings.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/deployment/export_format.h"
#include "s2nnds/networks/evaluator.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/evaluation_run.h"
#include "s2nnds/runs/threads.h"
#include "s2nnds/runs/training_run.h"
#include "s2nnds/runs/verification_run.h"
#include "s2nnds/runs/version.h"

namespace py = pybind11;

namespace {

using s2nnds::Points;
using s2nnds::PreparedRun;
using s2nnds::RunRecord;
using s2nnds::Vector;

using Array = py::array_t<double, py::array::c_style>;

// The array takes the matrix over: nothing is copied.
template <typename Matrix>
Array to_array(Matrix&& matrix, std::vector<py::ssize_t> shape) {
  auto* owned = new std::decay_t<Matrix>(std::forward<Matrix>(matrix));
  const py::capsule owner(owned, [](void* p) { delete static_cast<std::decay_t<Matrix>*>(p); });
  return Array(std::move(shape), owned->data(), owner);
}
Array to_array(Points matrix) {
  const std::vector<py::ssize_t> shape = {matrix.rows(), matrix.cols()};
  return to_array(std::move(matrix), shape);
}
Array to_array(Vector vector) {
  const std::vector<py::ssize_t> shape = {vector.size()};
  return to_array(std::move(vector), shape);
}

// The array's own memory, [N, n].
Eigen::Map<const Points> points_in(const Array& array) {
  s2nnds::check(array.ndim() == 2, "points: found {} dimensions, expected 2", array.ndim());
  return {array.data(), array.shape(0), array.shape(1)};
}

// A configuration as the Python modules hand it over: TOML, what to call it in messages, and settings on top.
struct ConfigText {
  std::string text;
  std::string source;
  std::vector<std::string> settings;

  s2nnds::Config parse() const { return s2nnds::parse_config(text, source, settings); }
};

py::dict data_of(const PreparedRun& setup) {
  py::list demonstrations;
  for (const s2nnds::Demonstration& d : setup.data.demonstrations)
    demonstrations.append(py::make_tuple(to_array(d.time), to_array(d.position), to_array(d.velocity)));
  py::dict data;
  data["unit"] = setup.data.frame.unit;
  data["dimension"] = setup.data.dimension;
  data["normalization"] = setup.data.frame.normalization;
  data["position_scale"] = setup.data.frame.position_scale;
  data["velocity_scale"] = setup.data.frame.velocity_scale;
  data["phase_start"] = setup.data.frame.phase_start;
  data["frame_name"] = setup.data.frame.name;
  data["goal"] = to_array(setup.data.frame.goal);
  data["goals"] = to_array(setup.data.frame.goals);
  data["train"] = setup.data.split.train;
  data["test"] = setup.data.split.test;
  data["demonstrations"] = demonstrations;
  return data;
}

PreparedRun prepared(const ConfigText& config, const std::string& data) {
  const py::gil_scoped_release release;
  return s2nnds::prepare(config.parse(), s2nnds::data_directory(data));
}

std::string name_of(s2nnds::Stage stage) {
  switch (stage) {
    case s2nnds::Stage::search:
      return "search";
    case s2nnds::Stage::imitation_finetune:
      return "imitation_finetune";
    case s2nnds::Stage::enlarge:
      return "enlarge";
  }
  s2nnds::fail("stage: found the value {}, expected 0 to 2", static_cast<int>(stage));
}

py::dict round_of(const s2nnds::RoundSummary& row) {
  py::dict counts;
  for (std::size_t q = 0; q < s2nnds::all_conditions.size(); ++q)
    counts[py::str(std::string(to_string(s2nnds::all_conditions[q])))] = row.counts[q];
  py::dict round;
  round["round"] = row.round;
  round["stage"] = name_of(row.stage);
  round["loss"] = row.loss;
  round["mse"] = row.mse;
  round["counterexamples"] = counts;
  round["safe_share"] = row.safe_share;
  round["volume"] = row.volume;
  round["seconds"] = row.seconds;
  return round;
}

// Lets Python handle a signal that came in the meantime: of Ctrl-C it makes a KeyboardInterrupt, which is thrown here.
void check_signals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

// Trains, verifies and evaluates as the program does. The run file at `path` holds each round before on_round hears of
// it, so whatever stops the training here leaves a checkpoint to go on from.
void train_to(const std::string& path, const PreparedRun& setup, RunRecord record,
              const py::object& on_round) {
  const py::gil_scoped_release release;
  s2nnds::RoundSummary last;
  s2nnds::TrainingHooks hooks;
  hooks.progress = [&](const s2nnds::RoundSummary& row) { last = row; };
  hooks.checkpoint = [&](const RunRecord& current) {
    s2nnds::save_run(path, current);
    const py::gil_scoped_acquire acquire;
    check_signals();
    if (!on_round.is_none()) on_round(round_of(last));
  };
  s2nnds::train(setup, record, hooks);
  s2nnds::verify_as_configured(setup, record);
  s2nnds::evaluate(setup, record);
  s2nnds::save_run(path, record);
}

void train(const ConfigText& config, const std::string& path, const std::string& data, int threads,
           const py::object& on_round) {
  s2nnds::set_threads(threads);
  const PreparedRun setup = prepared(config, data);
  const std::string text = s2nnds::with_settings(config.text, config.source, config.settings);
  train_to(path, setup, s2nnds::new_record(setup, text), on_round);
}

void resume(const std::string& from, const std::string& path, int threads, const py::object& on_round) {
  s2nnds::set_threads(threads);
  RunRecord record = s2nnds::load_run(from);
  s2nnds::check(record.checkpoint.has_value(), "{}: found no checkpoint, expected one to go on from", from);
  const PreparedRun setup = s2nnds::prepare(record);
  train_to(path, setup, std::move(record), on_round);
}

void verify(const std::string& path, const std::string& method, int threads,
            std::optional<std::int64_t> samples, std::optional<double> epsilon, std::optional<double> beta) {
  const py::gil_scoped_release release;
  s2nnds::set_threads(threads);
  RunRecord record = s2nnds::load_run(path);
  const PreparedRun setup = s2nnds::prepare(record);
  s2nnds::VerificationOptions options = setup.config.verification;
  if (samples) options.sampled.samples = options.conformal.samples = *samples;
  if (epsilon) options.conformal.epsilon = *epsilon;
  if (beta) options.conformal.beta = *beta;
  s2nnds::validate(options);
  s2nnds::verify(setup, record, s2nnds::enum_from<s2nnds::Method>(method), options);
  s2nnds::save_run(path, record);
}

void evaluate(const std::string& path, int threads) {
  const py::gil_scoped_release release;
  s2nnds::set_threads(threads);
  RunRecord record = s2nnds::load_certified_run(path);
  s2nnds::evaluate(s2nnds::prepare(record), record);
  s2nnds::save_run(path, record);
}

void export_policy(const std::string& run, const std::string& format, const std::string& precision,
                   const std::string& path) {
  const py::gil_scoped_release release;
  s2nnds::export_policy(s2nnds::policy_of(s2nnds::load_certified_run(run)),
                        s2nnds::export_format_from(format), {s2nnds::header_precision_from(precision)}, path);
}

std::vector<std::pair<std::string, std::string>> export_endings() {
  std::vector<std::pair<std::string, std::string>> endings;
  for (const s2nnds::ExportFormat& format : s2nnds::export_formats())
    endings.emplace_back(format.name, format.ending);
  return endings;
}

// One network, ready for many evaluations. A layer is (weight [out, in], bias [out], name of the activation).
std::unique_ptr<s2nnds::Evaluator> make_evaluator(
    const std::vector<std::tuple<Array, Array, std::string>>& layers, const std::string& head,
    double quadratic) {
  s2nnds::NetworkWeights network;
  for (const auto& [weight, bias, activation] : layers) {
    network.layers.push_back({points_in(weight), Eigen::Map<const Vector>(bias.data(), bias.size()),
                              s2nnds::activation_from(activation)});
  }
  network.head = s2nnds::head_from(head);
  network.quadratic = quadratic;
  return std::make_unique<s2nnds::Evaluator>(network);
}

Array evaluate_network(const s2nnds::Evaluator& network, const Array& x) {
  const Eigen::Map<const Points> points = points_in(x);
  Points value;
  {
    const py::gil_scoped_release release;
    value = network.value(points);
  }
  return to_array(std::move(value));
}

Array level(const s2nnds::Region& region, const Array& x) { return to_array(region.level(points_in(x))); }

}  // namespace

PYBIND11_MODULE(_native, module) {
  py::register_local_exception<s2nnds::Error>(module, "Error", PyExc_ValueError);
  py::class_<ConfigText>(module, "ConfigText")
      .def(py::init([](std::string text, std::string source, std::vector<std::string> settings) {
             return ConfigText{std::move(text), std::move(source), std::move(settings)};
           }),
           py::arg("text"), py::arg("source"), py::arg("settings"))
      .def_property_readonly("name", [](const ConfigText& config) { return config.parse().name; })
      .def_property_readonly("seed", [](const ConfigText& config) { return config.parse().seed; });
  py::class_<PreparedRun>(module, "PreparedRun")
      .def(py::init(&prepared), py::arg("config"), py::arg("data"))
      .def_property_readonly("name", [](const PreparedRun& run) { return run.config.name; })
      .def_property_readonly("data", &data_of)
      .def_property_readonly("workspace_lower",
                             [](const PreparedRun& run) { return to_array(run.problem.workspace.lower); })
      .def_property_readonly("workspace_upper",
                             [](const PreparedRun& run) { return to_array(run.problem.workspace.upper); })
      .def_property_readonly("unsafe", [](const PreparedRun& run) { return run.problem.unsafe->describe(); })
      .def_property_readonly("initial",
                             [](const PreparedRun& run) { return run.problem.initial->describe(); })
      .def("unsafe_level",
           [](const PreparedRun& run, const Array& x) { return level(*run.problem.unsafe, x); })
      .def("initial_level",
           [](const PreparedRun& run, const Array& x) { return level(*run.problem.initial, x); });
  py::class_<s2nnds::Evaluator>(module, "Evaluator")
      .def(py::init(&make_evaluator), py::arg("layers"), py::arg("head"), py::arg("quadratic"))
      // A converted array would be a copy: the caller converts where it must.
      .def("value", &evaluate_network, py::arg("x").noconvert());
  module.def("train", &train, py::arg("config"), py::arg("path"), py::arg("data"), py::arg("threads"),
             py::arg("on_round"));
  module.def("resume", &resume, py::arg("run"), py::arg("path"), py::arg("threads"), py::arg("on_round"));
  module.def("verify", &verify, py::arg("run"), py::arg("method"), py::arg("threads"), py::arg("samples"),
             py::arg("epsilon"), py::arg("beta"));
  module.def("evaluate", &evaluate, py::arg("run"), py::arg("threads"));
  module.def("export_policy", &export_policy, py::arg("run"), py::arg("format"), py::arg("precision"),
             py::arg("path"));
  module.def("export_endings", &export_endings);
  module.attr("version") = s2nnds::program_version();
}
