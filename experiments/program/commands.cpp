// SPDX-License-Identifier: BSD-3-Clause
#include "commands.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "need_libtorch.h"
#include "progress.h"
#include "range_command.h"
#include "run_report.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/json_text.h"
#include "s2nnds/core/python_module.h"
#include "s2nnds/core/settings.h"
#include "s2nnds/data/phase.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/deployment/export_format.h"
#include "s2nnds/evaluation/trajectory_metrics.h"
#include "s2nnds/runs/adaptation.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/displaced_obstacle.h"
#include "s2nnds/runs/evaluation_run.h"
#include "s2nnds/runs/motion_report.h"
#include "s2nnds/runs/scene.h"
#include "s2nnds/runs/statement.h"
#include "s2nnds/runs/summary.h"
#include "s2nnds/runs/threads.h"
#include "s2nnds/runs/training_run.h"
#include "s2nnds/runs/user_units.h"
#include "s2nnds/runs/verification_run.h"
#include "writable.h"

namespace s2nnds::program {
namespace {

namespace fs = std::filesystem;

void report(const RunRecord& record, const std::string& path, const CommonArguments& common) {
  fmt::print("{}", first_screen(record, path));
  if (common.json) fmt::print("{}\n", summary_json(record, path));
}

using nlohmann::ordered_json;

// The errors of each demonstration of a split, one line each; the same for --json.
ordered_json report_demonstrations(const PreparedRun& setup, const RunRecord& record,
                                   const std::string& split) {
  const Dynamics f = record.networks.dynamics();
  const UserUnits units(record);
  const std::vector<std::int64_t>& members = split == "train"  ? setup.data.split.train
                                             : split == "test" ? setup.data.split.test
                                                               : setup.data.split.validation;
  ordered_json rows = ordered_json::array();
  for (const std::int64_t k : members) {
    const Demonstration& demonstration = setup.demonstrations[static_cast<std::size_t>(k)];
    const MotionErrors errors =
        motion_errors(f, {demonstration}, setup.config.evaluation.rollout, setup.problem.places());
    fmt::print(
        "  demonstration {} ({}): velocity RMS {}, motion DTW {}{}\n", k, split,
        units.speed(std::sqrt(errors.mse)), units.length(errors.dtw),
        units.in_data() ? "" : fmt::format("; mse {:.4g}, sd {:.4g} (normalised)", errors.mse, errors.sd));
    rows.push_back({{"demonstration", k},
                    {"split", split},
                    {"mse", errors.mse},
                    {"sd", errors.sd},
                    {"dtw", errors.dtw},
                    {"dtw_independent", errors.dtw_independent}});
  }
  return rows;
}

// The stored run made concrete, from what it keeps itself; says which files have changed since.
PreparedRun prepare_stored(const RunRecord& record, const std::string& data) {
  PreparedRun setup = prepare(record);
  for (const std::string& name : setup.files.changed_in(data)) {
    spdlog::warn("{} in {} is not what this run was made with; the run uses its own copy", name, data);
  }
  return setup;
}

// How far the demonstrations stay from the obstacle, before hours are spent on it.
void log_clearances(const PreparedRun& setup) {
  const std::vector<std::string> texts = clearance_texts(
      clearances_of(setup.problem, setup.config.problem, setup.demonstrations, setup.data.frame),
      setup.data.frame);
  for (std::size_t k = 0; k < texts.size(); ++k)
    spdlog::info("clearance of demonstration {}: {}", k, texts[k]);
}

// Whether the run has at least the guarantee that this method can give; a proof of poses is one of orientations too.
int exit_code(Method method, const PreparedRun& setup, const RunRecord& record) {
  const Guarantee wanted = method == Method::sampled        ? Guarantee::sampled
                           : method == Method::conformal    ? Guarantee::conformal
                           : setup.problem.workspace_margin ? Guarantee::invariant
                                                            : Guarantee::proved;
  const bool turns = method == Method::proof && setup.data.frame.has_orientation();
  const OrientationCertificate& turning = record.certificate.orientation;
  if (turns && !(turning.proved && (turning.tool.empty() || turning.tool_clear))) return kNotVerified;
  return record.certificate.guarantee >= wanted ? kVerified : kNotVerified;
}

// The same of a motion that follows the demonstrations: what a training is for.
int exit_code_of_training(const PreparedRun& setup, const RunRecord& record) {
  return follows_demonstrations(record) ? exit_code(*setup.config.verification.method, setup, record)
                                        : kNotVerified;
}

std::string sibling(const std::string& run, const std::string& suffix) {
  return fs::path(run).replace_extension().string() + suffix;
}

// Says what was read, and what of it no motion x' = f(x) can follow, before anything that may be wrong with goal and
// sets: it may be why.
DemonstrationSet read_and_report(const DataOptions& options, const std::string& data) {
  DemonstrationSet as_read = read_demonstrations(options, data, print_reading);
  for (const std::string& line : as_read.report) spdlog::info("data: {}", line);
  const Survey found = survey(as_read);
  const PhaseChoice phase = choose_phase(options.state, as_read, found);
  if (phase.used) spdlog::info("{}", phase.reason);
  for (const std::string& text : warnings_of(found, as_read.unit, phase.used)) spdlog::warn("{}", text);
  return as_read;
}

// Refuses what no training can solve, and says what else no motion can do, before any time is spent on it.
void look_before_training(const PreparedRun& setup, const std::string& source) {
  const std::vector<Demonstration> shown = setup.train();
  const std::vector<std::string> reasons = impossibilities(setup.problem, setup.data.frame, shown);
  check(reasons.empty(), "{}: {}", source, reasons.empty() ? "" : reasons.front());
  if (const auto text = sides_warning(setup.problem, setup.data.frame, shown)) spdlog::warn("{}", *text);
  if (const std::string text = dimension_warning(setup.config, setup.data.dimension); !text.empty())
    spdlog::warn("{}", text);
}

struct TrainingStart {
  std::string path;
  PreparedRun setup;
  RunRecord record;
};

TrainingStart start_from_config(const TrainArguments& arguments, const std::string& data) {
  TrainingStart start;
  std::vector<std::string> assignments = arguments.assignments;
  if (arguments.seed) assignments.push_back(fmt::format("seed={}", *arguments.seed));
  const std::string text = read_config_text(arguments.config);
  const Config config = parse_config(text, arguments.config, assignments);
  start.path = arguments.out.empty() ? fmt::format("{}-seed{}.h5", config.name, config.seed) : arguments.out;
  check_writable(start.path);
  DemonstrationSet as_read = read_and_report(config.data, data);
  const auto told = std::ssize(as_read.report);
  start.setup = prepare(config, std::move(as_read), RegionFiles(data));
  for (auto k = told; k < std::ssize(start.setup.data.report); ++k)
    spdlog::info("{}", start.setup.data.report[static_cast<std::size_t>(k)]);
  start.record = new_record(start.setup, with_settings(text, arguments.config, assignments));
  return start;
}

TrainingStart start_from_run(const TrainArguments& arguments, const std::string& data) {
  check(arguments.assignments.empty() && !arguments.seed && arguments.config.empty(),
        "train --resume: found a configuration, --set or --seed as well; a resumed run keeps its own");
  TrainingStart start;
  start.path = arguments.out.empty() ? arguments.resume : arguments.out;
  check_writable(start.path);
  start.record = load_run(arguments.resume);
  check(start.record.checkpoint.has_value(), "{}: found no checkpoint, expected one to go on from",
        arguments.resume);
  start.setup = prepare_stored(start.record, data);
  return start;
}

}  // namespace

int train(const TrainArguments& arguments, const CommonArguments& common) {
  need_libtorch(common);
  set_threads(common.threads);
  const std::string data = data_directory(common.data);
  TrainingStart start =
      arguments.resume.empty() ? start_from_config(arguments, data) : start_from_run(arguments, data);
  TrainingHooks hooks;
  hooks.progress = print_round;
  hooks.until_certified = arguments.until == "certified";
  hooks.checkpoint = [&](const RunRecord& record) { save_run(start.path, record); };
  spdlog::info("{}", frame_line(start.record));
  log_clearances(start.setup);
  if (arguments.resume.empty()) look_before_training(start.setup, arguments.config);
  const TrainerSummary summary = s2nnds::train(start.setup, start.record, hooks);
  if (summary.left_out_samples > 0) {
    spdlog::warn("{} demonstration samples within {} of the unsafe set were left out of the fit",
                 summary.left_out_samples,
                 UserUnits(start.record).length(start.setup.config.training.obstacle_margin));
  }
  verify_as_configured(start.setup, start.record, proof_printer());
  save_run(start.path, start.record);  // what is known is there while the motion is being measured
  spdlog::info("guarantee={}", to_string(start.record.certificate.guarantee));
  s2nnds::evaluate(start.setup, start.record);
  save_run(start.path, start.record);
  report(start.record, start.path, common);
  return exit_code_of_training(start.setup, start.record);
}

int adapt(const AdaptArguments& arguments, const CommonArguments& common) {
  need_libtorch(common);
  set_threads(common.threads);
  const RunRecord old = load_certified_run(arguments.run);
  const std::string path = arguments.out.empty() ? sibling(arguments.run, "-adapted.h5") : arguments.out;
  check_writable(path);
  if (const std::string hint = range_hint(old, arguments.assignments); !hint.empty())
    spdlog::info("{}", hint);
  const AdaptationResult found = s2nnds::adapt(old, arguments.assignments, data_directory(common.data),
                                               {.progress = print_round, .cancelled = {}});
  save_run(path, found.record);
  fmt::print("{}", first_screen(found.record, path));
  const UserUnits units(found.record);
  const char* words = found.outcome == Adaptation::held ? "the old networks are certified in the new scene"
                      : found.outcome == Adaptation::adapted ? "trained on from the old networks"
                      : found.outcome == Adaptation::anew    ? "trained from scratch"
                                                             : "no certificate was found";
  fmt::print("  {:<14}  {}, in {:.2f} s; the motion moved by at most {}\n", "adaptation", words,
             found.seconds, units.length(found.motion_change));
  if (common.json) {
    ordered_json summary = ordered_json::parse(summary_json(found.record, path));
    summary["adaptation"] = {{"outcome", to_string(found.outcome)},
                             {"seconds", found.seconds},
                             {"motion_change", found.motion_change}};
    fmt::print("{}\n", s2nnds::json_text(summary));
  }
  return found.outcome == Adaptation::failed ? kNotVerified : kVerified;
}

// The execution model is no part of what was trained: another one asks for another proof alone.
void set_execution(const std::vector<std::string>& assignments, RunRecord& record) {
  for (const std::string& assignment : assignments) {
    check(assignment.rfind("execution.", 0) == 0,
          "verify --set: found \"{}\", expected execution.key=value; other keys need a new training",
          assignment);
  }
  const std::string text = with_settings(record.config.text, "the run's configuration", assignments);
  Config config = parse_config(record.config.resolved, "the run's configuration");
  config.execution = parse_config(text, "the run's configuration").execution;
  record.config = {text, to_toml(config), flatten(config)};
}

int verify(const VerifyArguments& arguments, const CommonArguments& common) {
  set_threads(common.threads);
  RunRecord record = load_run(arguments.run);
  check_writable(arguments.run);
  if (!arguments.assignments.empty()) set_execution(arguments.assignments, record);
  const PreparedRun setup = prepare_stored(record, data_directory(common.data));
  VerificationOptions options = setup.config.verification;
  if (arguments.samples) options.sampled.samples = options.conformal.samples = *arguments.samples;
  if (arguments.epsilon) options.conformal.epsilon = *arguments.epsilon;
  if (arguments.beta) options.conformal.beta = *arguments.beta;
  validate(options);
  const Method method = enum_from<Method>(arguments.method);
  check(arguments.artifact.empty() || method == Method::proof,
        "verify: found --artifact with --method {}, expected proof", arguments.method);
  if (!arguments.artifact.empty()) check_writable(arguments.artifact);
  check(arguments.speed.empty() || (method == Method::proof && !setup.config.execution.is_ideal()),
        "verify --speed: expected --method proof and an execution model in the configuration or by --set "
        "execution.key=value");
  if (!record.certificate.conditions.empty() && !is_intact(setup, record)) {
    spdlog::warn(
        "{}: its certificate spoke of other weights or another problem, or was changed; a new one begins",
        arguments.run);
  }
  ProofCovers covers;
  s2nnds::verify(setup, record, method, options, proof_printer(),
                 arguments.artifact.empty() ? nullptr : &covers);
  if (!arguments.speed.empty()) {
    if (record.certificate.guarantee == Guarantee::invariant) find_certified_speeds(setup, record);
    const std::string speeds = certified_speeds_in_words(record);
    fmt::print("{}\n", speeds.empty() ? "no speed is certified" : speeds);
  }
  save_run(arguments.run, record);
  if (!covers.empty()) save_proof(arguments.artifact, record, covers);
  fmt::print("{}", condition_tables(record));
  report(record, arguments.run, common);
  if (!covers.empty()) {
    fmt::print("  proof           {}\n", arguments.artifact);
  } else if (!arguments.artifact.empty()) {
    spdlog::warn("{}: not written, since the run is not proved to be invariant", arguments.artifact);
  }
  for (const ConditionVerdict& found : record.certificate.conditions) {
    const Verdict wanted = method == Method::proof ? Verdict::proved : Verdict::passed;
    if (found.method == method && found.verdict != wanted) return kNotVerified;
  }
  return exit_code(method, setup, record);
}

int evaluate(const EvaluateArguments& arguments, const CommonArguments& common) {
  set_threads(common.threads);
  RunRecord record = load_certified_run(arguments.run);
  check_writable(arguments.run);
  const PreparedRun setup = prepare_stored(record, data_directory(common.data));
  s2nnds::evaluate(setup, record);
  save_run(arguments.run, record);
  fmt::print("{}", first_screen(record, arguments.run));
  ordered_json demonstrations = ordered_json::array();
  for (const std::string& split : arguments.splits) {
    for (ordered_json& row : report_demonstrations(setup, record, split))
      demonstrations.push_back(std::move(row));
  }
  if (common.json) {
    ordered_json summary = ordered_json::parse(summary_json(record, arguments.run));
    if (!arguments.splits.empty()) summary["demonstrations"] = demonstrations;
    fmt::print("{}\n", s2nnds::json_text(summary));
  }
  return exit_code_of_training(setup, record);
}

int export_policy(const ExportArguments& arguments, const CommonArguments& common) {
  const ExportFormat& format = export_format_from(arguments.format);
  if (format.libtorch) need_libtorch(common);
  set_threads(common.threads);
  const RunRecord record = load_certified_run(arguments.run);
  const std::string path =
      arguments.out.empty() ? sibling(arguments.run, std::string(format.ending)) : arguments.out;
  check_writable(path);
  const Policy policy = policy_of(record);
  ExportOptions options{header_precision_from(arguments.precision)};
  if (!arguments.range.obstacle.empty())
    options.range = chosen_range(arguments.range, prepare(record), record);
  export_policy(policy, format, options, path);
  fmt::print("{}: {}, guarantee {}\n", path, format.title, policy.info.guarantee);
  if (options.range) fmt::print("{}", paragraph(range_statement(record, *options.range)));
  if (common.json) fmt::print("{}\n", summary_json(record, arguments.run));
  return kVerified;
}

int plot(const PlotArguments& arguments) {
  load_certified_run(arguments.run);  // says what is wrong with a bad file
  const std::string out = arguments.out.empty() ? sibling(arguments.run, "-figures") : arguments.out;
  return run_python_module("plot", "plot_run", {arguments.run, "--out", out});
}

int import_recordings(const std::vector<std::string>& words) {
  return run_python_module("import", "import_recordings", words);
}

int info(const InfoArguments& arguments, const CommonArguments& common) {
  set_threads(common.threads);
  const RunRecord record = load_certified_run(arguments.run);
  fmt::print("{}", first_screen(record, arguments.run));
  if (arguments.all) {
    fmt::print("\n{}", details(record));
  } else {
    fmt::print("  --all tells conditions, configuration, the last rounds, hashes and versions.\n");
  }
  if (common.json) fmt::print("{}\n", summary_json(record, arguments.run));
  return kVerified;
}

}  // namespace s2nnds::program
