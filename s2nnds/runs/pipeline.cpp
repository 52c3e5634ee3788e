#include "s2nnds/runs/pipeline.h"

#include <fmt/ranges.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "s2nnds/core/check.h"
#include "s2nnds/evaluation/safe_area.h"
#include "s2nnds/evaluation/trajectory_metrics.h"
#include "s2nnds/runs/disturbance_falsifier.h"
#include "s2nnds/runs/proof_source.h"
#include "s2nnds/runs/threads.h"
#include "s2nnds/runs/training_checkpoint.h"
#include "s2nnds/training/falsifier.h"

namespace s2nnds {
namespace {

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

void set_timing(RunRecord& record, const std::string& name, double seconds) {
  for (auto& [known, value] : record.timing) {
    if (known == name) {
      value = seconds;
      return;
    }
  }
  record.timing.emplace_back(name, seconds);
}

// Every condition that has a verdict of this method has `verdict`, and there is at least one.
bool all_are(const Certificate& certificate, const std::string& method, const std::string& verdict) {
  bool any = false;
  for (const ConditionVerdict& found : certificate.conditions) {
    if (found.method != method) continue;
    any = true;
    if (found.verdict != verdict) return false;
  }
  return any;
}

constexpr const char* kGoalIsSafe = "goal_is_safe";                  // B(0) <= 0
constexpr const char* kInitialInWorkspace = "initial_in_workspace";  // X0 lies in X

bool is_proved(const Certificate& certificate, std::string_view condition) {
  for (const ConditionVerdict& found : certificate.conditions) {
    if (found.method == "proof" && found.condition == condition) return found.verdict == "proved";
  }
  return false;
}

// The strongest guarantee that the verdicts on these weights support.
Guarantee guarantee_of(const Certificate& certificate, const SafetyProblem& problem) {
  if (all_are(certificate, "proof", "proved")) return Guarantee::invariant;
  bool proved = true;
  for (Condition condition : all_conditions) {
    if (condition == Condition::containment && !problem.workspace_margin) continue;
    proved = proved && is_proved(certificate, to_string(condition));
  }
  if (proved) return Guarantee::proved;
  if (all_are(certificate, "conformal", "passed")) return Guarantee::conformal;
  return all_are(certificate, "sampled", "passed") ? Guarantee::sampled : Guarantee::none;
}

ConditionVerdict side_condition(const char* name, bool holds) {
  ConditionVerdict verdict;
  verdict.condition = name;
  verdict.method = "proof";
  verdict.verdict = holds ? "proved" : "undecided";
  return verdict;
}

// The proof's verdicts on all conditions and on what invariance needs besides; open boxes go into the record.
std::vector<ConditionVerdict> verify_by_proof(const PreparedRun& setup, RunRecord& record,
                                              const VerificationOptions& options,
                                              const ProofProgress& progress) {
  const ProofFunctions functions = ProofFunctions::of(record.networks);
  const ProofResult result =
      prove(functions, setup.problem, record.certificate.level_band, options.proof, progress);
  std::vector<ConditionVerdict> verdicts;
  record.open_boxes.clear();
  for (const ConditionProof& proof : result.conditions) {
    verdicts.push_back(proof.verdict);
    if (proof.open_lower.rows() == 0) continue;
    Points corners(proof.open_lower.rows(), 2 * proof.open_lower.cols());
    corners << proof.open_lower, proof.open_upper;
    record.open_boxes.emplace_back(std::string(to_string(proof.condition)), corners);
  }
  verdicts.push_back(side_condition(kGoalIsSafe, result.goal_is_safe));
  verdicts.push_back(side_condition(kInitialInWorkspace, result.initial_in_workspace));
  record.certificate.disturbance_margin = record.certificate.convergence_radius = 0.0;
  if (result.guarantee == Guarantee::invariant) {
    const DisturbanceMargin margin = disturbance_margin(functions, setup.problem, options.disturbance);
    record.certificate.disturbance_margin = margin.margin;
    record.certificate.convergence_radius = margin.convergence_radius;
    record.certificate.float32_error = float32_error(record.networks.f, setup.problem.workspace);
    set_timing(record, "disturbance_margin", margin.seconds);
  }
  set_timing(record, "proof", result.seconds);
  return verdicts;
}

Points grid_points(const std::vector<Vector>& axes) {
  Eigen::Index total = 1;
  for (const Vector& axis : axes) total *= axis.size();
  Points x(total, static_cast<Eigen::Index>(axes.size()));
  for (Eigen::Index i = 0; i < total; ++i) {
    Eigen::Index rest = i;
    for (Eigen::Index k = x.cols() - 1; k >= 0; --k) {
      x(i, k) = axes[k][rest % axes[k].size()];
      rest /= axes[k].size();
    }
  }
  return x;
}

Grid make_grid(const PreparedRun& setup, const Networks& networks) {
  const Eigen::Index n = setup.problem.dimension();
  const Eigen::Index side = n == 2 ? setup.config.evaluation.grid_points
                                   : std::min<Eigen::Index>(41, setup.config.evaluation.grid_points);
  Grid grid;
  const Box& x = setup.problem.workspace;
  for (Eigen::Index k = 0; k < n; ++k) grid.axes.push_back(Vector::LinSpaced(side, x.lower[k], x.upper[k]));
  const Points points = grid_points(grid.axes);
  grid.unsafe = setup.problem.unsafe->level(points);
  grid.initial = setup.problem.initial->level(points);
  grid.V = networks.V.value(points);
  grid.B = networks.B.value(points);
  grid.velocity = networks.f.value(points);
  return grid;
}

std::vector<StoredRollout> make_rollouts(const PreparedRun& setup, const NetworkWeights& f) {
  std::vector<StoredRollout> rollouts;
  const auto add = [&](const std::vector<Demonstration>& demonstrations, const std::string& kind) {
    for (const Demonstration& d : demonstrations) {
      const Rollout rollout =
          roll_out(f, setup.problem, d.position.row(0).transpose(), setup.config.evaluation.rollout);
      rollouts.push_back({kind, std::string(to_string(rollout.stop)), rollout.time, rollout.position});
    }
  };
  add(setup.train(), "train");
  add(setup.test(), "test");
  return rollouts;
}

std::string number(double value) { return fmt::format("{:.4g}", value); }

}  // namespace

PreparedRun prepare(const Config& config, const std::string& data_dir) {
  PreparedRun setup;
  setup.config = config;
  setup.raw = read_demonstrations(config.data, data_dir);
  setup.normalization = find_normalization(config.data.normalization, setup.raw.demonstrations);
  setup.demonstrations = normalize(setup.raw.demonstrations, setup.normalization);
  setup.split = split_demonstrations(setup.demonstrations.size(), config.data.test, config.data.validation);
  setup.problem = make_problem(config.problem, setup.demonstrations, data_dir);
  return setup;
}

PreparedRun prepare(const RunRecord& record, const std::string& data_dir) {
  PreparedRun setup;
  setup.config = parse_config(record.config.resolved, "the run's configuration");
  setup.normalization = record.data.normalization;
  setup.split = record.data.split;
  setup.demonstrations = record.data.normalized();
  setup.problem = make_problem(setup.config.problem, setup.demonstrations, data_dir);
  return setup;
}

RunRecord new_record(const PreparedRun& setup, const std::string& text) {
  RunRecord record;
  record.program_version = program_version();
  record.library_versions = library_versions();
  record.created = time_stamp();
  record.name = setup.config.name;
  record.seed = setup.config.seed;
  record.config = {text, to_toml(setup.config), flatten(setup.config)};
  record.data.unit = setup.raw.unit;
  record.data.dimension = setup.problem.dimension();
  record.data.normalization = setup.normalization;
  record.data.split = setup.split;
  record.data.demonstrations = setup.demonstrations;
  for (std::size_t k = 0; k < record.data.demonstrations.size(); ++k) {
    record.data.demonstrations[k].time = setup.raw.demonstrations[k].time;
  }
  record.problem = {setup.problem.unsafe->describe(), setup.problem.initial->describe(),
                    setup.problem.workspace_margin ? setup.problem.containment : 0.0,
                    setup.config.training.level_band, setup.problem.workspace};
  return record;
}

TrainerSummary train(const PreparedRun& setup, RunRecord& record, const TrainingHooks& hooks) {
  const Config& config = setup.config;
  Trainer trainer(setup.problem, setup.train(), config.networks, config.training, config.seed);
  const FalsifierOptions search{config.training.samples, config.training.pool_additions};
  trainer.add_source(std::make_shared<RandomFalsifier>(setup.problem, search));
  trainer.add_source(std::make_shared<LocalSearchFalsifier>(setup.problem, search));
  if (config.verification.method == "proof") {
    ProofOptions quick = ProofOptions::fail_fast();
    if (setup.problem.dimension() > 2)
      quick.max_boxes = quick.max_after_refuted = config.verification.proof.max_boxes;
    trainer.add_source(std::make_shared<ProofSource>(quick, config.training.pool_additions));
    trainer.add_source(std::make_shared<DisturbanceFalsifier>(config.verification.disturbance,
                                                              config.training.pool_additions));
  }
  trainer.set_rollout_labels([&](const NetworkWeights& f, const Points& starts) {
    return rollout_is_safe(f, setup.problem, starts);
  });
  if (record.checkpoint) trainer.restore(to_trainer_state(record));
  trainer.on_round([&](const RoundSummary& row, const Trainer& current) {
    store_trainer_state(current.state(), record);
    // All rounds after it keep what was clean. Where the prover is a source, everything is proved from here on.
    if (row.clean() && row.stage == Stage::search && row.round >= config.training.min_rounds)
      set_timing(record, "first_clean_round", row.seconds);
    if (hooks.progress) hooks.progress(row);
    if (hooks.checkpoint) hooks.checkpoint(record);
    return std::isfinite(row.loss);
  });
  const TrainerSummary summary = trainer.run();
  record.checkpoint->finished = true;
  set_timing(record, "training", summary.seconds);
  record.certificate = {};
  record.certificate.weight_hash = weight_hash(record.networks);
  record.certificate.level_band = config.training.level_band;
  return summary;
}

void verify(const PreparedRun& setup, RunRecord& record, const std::string& method,
            const VerificationOptions& options, const ProofProgress& progress) {
  const Stopwatch watch;
  Certificate& certificate = record.certificate;
  const std::string hash = weight_hash(record.networks);
  if (certificate.weight_hash != hash) {
    check(certificate.weight_hash.empty(), "certificate: it speaks of weights with hash {}, the run holds {}",
          certificate.weight_hash, hash);
    certificate.weight_hash = hash;
  }
  certificate.level_band = setup.config.training.level_band;
  std::vector<ConditionVerdict> verdicts;
  if (method == "sampled") {
    verdicts =
        verify_sampled(record.networks, setup.problem, certificate.level_band, options.sampled, record.seed);
  } else if (method == "conformal") {
    verdicts = verify_conformal(record.networks, setup.problem, certificate.level_band, options.conformal,
                                record.seed, certificate.attempts + 1);
    ++certificate.attempts;
  } else {
    check(method == "proof", "verification: found method \"{}\", expected sampled, conformal or proof",
          method);
    verdicts = verify_by_proof(setup, record, options, progress);
  }
  std::erase_if(certificate.conditions, [&](const ConditionVerdict& old) { return old.method == method; });
  certificate.conditions.insert(certificate.conditions.end(), verdicts.begin(), verdicts.end());
  certificate.method = method;
  certificate.guarantee = std::string(to_string(guarantee_of(certificate, setup.problem)));
  certificate.statement = guarantee_statement(record);
  set_timing(record, "verification_" + method, watch.seconds());
}

void evaluate(const PreparedRun& setup, RunRecord& record) {
  const Stopwatch watch;
  const Networks& networks = record.networks;
  const RolloutOptions& rollout = setup.config.evaluation.rollout;
  const MotionErrors train_errors = motion_errors(networks.f, setup.train(), rollout);
  EvaluationSummary summary;
  summary.mse_train = train_errors.mse;
  summary.sd_train = train_errors.sd;
  summary.dtw_train = train_errors.dtw;
  if (!setup.split.test.empty()) {
    const MotionErrors test = motion_errors(networks.f, setup.test(), rollout);
    summary.mse_test = test.mse;
    summary.sd_test = test.sd;
    summary.dtw_test = test.dtw;
    summary.dtw_independent_test = test.dtw_independent;
  }
  if (!setup.split.validation.empty()) {
    summary.mse_validation = motion_errors(networks.f, setup.validation(), rollout).mse;
  }
  const SafeArea area =
      measure_safe_area(networks, setup.problem, static_cast<int>(setup.config.evaluation.area_cells));
  summary.safe_area = area.safe_area;
  summary.true_safe_area = area.true_safe_area;
  summary.safe_area_ratio = area.ratio();
  record.evaluation = summary;
  record.rollouts = make_rollouts(setup, networks.f);
  record.grid.reset();
  if (setup.problem.dimension() <= 3) record.grid = make_grid(setup, networks);
  set_timing(record, "evaluation", watch.seconds());
}

namespace {

std::string proof_statement(const RunRecord& record) {
  const Certificate& c = record.certificate;
  std::string text = fmt::format(
      "Proved for every point of the workspace, in exact arithmetic for the networks with these "
      "double-precision weights "
      "(rounding of the proof itself is covered): V > 0 and V decreases along motions everywhere but at the "
      "goal, B <= 0 on the "
      "initial set, B > 0 on the unsafe set{}, and B decreases where |B| <= {}. ",
      record.problem.containment > 0 ? " and on the workspace's outer margin" : "", number(c.level_band));
  if (c.guarantee != "invariant") {
    return text +
           "It is not proved that {B <= 0} lies inside the workspace, so a motion is covered only while it "
           "stays inside.";
  }
  text +=
      "{B <= 0} lies inside the workspace and contains the initial set, so every motion xdot = f(x) that "
      "starts in it stays in "
      "it for ever, never touches the unsafe set, and converges to the goal.";
  if (!(c.disturbance_margin > 0)) return text + " No margin against disturbances was certified.";
  const double unit = record.data.normalization.velocity_scale,
               length = record.data.normalization.position_scale;
  text += fmt::format(
      " It also stays there under any disturbance xdot = f(x) + w with |w| <= {} (normalised; {} {}/s)",
      number(c.disturbance_margin), number(c.disturbance_margin * unit), record.data.unit);
  if (c.convergence_radius < record.problem.workspace.half_widths().minCoeff()) {
    text +=
        fmt::format(", and then converges to a ball of radius {} ({} {}) around the goal",
                    number(c.convergence_radius), number(c.convergence_radius * length), record.data.unit);
  }
  text += fmt::format(". Evaluating f in float32 is wrong by at most {} (normalised), which this margin {}.",
                      number(c.float32_error),
                      c.float32_error < c.disturbance_margin ? "covers" : "does NOT cover");
  return text;
}

std::string sample_statement(const RunRecord& record) {
  const Certificate& certificate = record.certificate;
  const std::string& method = certificate.guarantee;
  std::int64_t samples = 0, attempt = 0;
  double epsilon = 0.0, confidence = 0.0;
  for (const ConditionVerdict& verdict : certificate.conditions) {
    if (verdict.method != method) continue;
    samples = std::max(samples, verdict.samples);
    epsilon = std::max(epsilon, verdict.epsilon);
    confidence += verdict.beta;
    attempt = std::max(attempt, verdict.attempt);
  }
  if (method == "sampled") {
    return fmt::format(
        "No violation of any condition was found among {} uniform samples of the workspace (fewer in the "
        "smaller regions), "
        "seed {}. That is no statement about the points between them.",
        samples, record.seed);
  }
  return fmt::format(
      "With confidence 1 - {} (attempt {}, {} fresh samples a region, seed {}), each condition holds on all "
      "but a share of at "
      "most epsilon = {} of its region: V decreases along motions in the workspace, B <= 0 on the initial "
      "set, B > 0 on the "
      "unsafe set{}, and B decreases where |B| <= {}. This is a statement about random points, one at a "
      "time; a violation on a "
      "smaller set is not excluded, so it does not prove that every motion is safe.",
      number(confidence), attempt, samples, record.seed, number(epsilon),
      record.problem.containment > 0 ? " and on the workspace's outer margin" : "",
      number(certificate.level_band));
}

}  // namespace

namespace {

// Samples that passed must not hide a point that a proof knows to violate a condition.
std::string refutation(const Certificate& certificate) {
  std::string text;
  for (const ConditionVerdict& verdict : certificate.conditions) {
    if (verdict.method != "proof" || verdict.verdict != "refuted") continue;
    text += fmt::format(" But the proof REFUTED {}: it is violated at ({:.6g}).", verdict.condition,
                        fmt::join(verdict.witness, ", "));
  }
  return text;
}

}  // namespace

std::string guarantee_statement(const RunRecord& record) {
  const std::string& guarantee = record.certificate.guarantee;
  if (guarantee == "none") {
    return "Nothing is guaranteed: a condition was violated at a sampled point, or nothing was checked.";
  }
  const bool proof = guarantee == "proved" || guarantee == "invariant";
  return (proof ? proof_statement(record) : sample_statement(record)) + refutation(record.certificate) +
         " It speaks of the kinematic motion in normalised, goal-centred coordinates, not of a robot's "
         "tracking error.";
}

std::string summary_json(const RunRecord& record, const std::string& path) {
  using nlohmann::ordered_json;
  const auto real = [](double value) {
    return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
  };
  ordered_json json;
  json["name"] = record.name;
  json["seed"] = record.seed;
  json["guarantee"] = record.certificate.guarantee;
  json["conditions"] = ordered_json::object();
  for (const ConditionVerdict& verdict : record.certificate.conditions) {
    ordered_json& entry = json["conditions"][verdict.condition][verdict.method];
    entry = {{"verdict", verdict.verdict}, {"samples", verdict.samples}, {"violations", verdict.violations}};
    entry["worst"] = real(verdict.worst);
    if (verdict.method == "proof") {
      entry = {{"verdict", verdict.verdict},
               {"boxes", verdict.boxes},
               {"open_boxes", verdict.open_boxes},
               {"open_volume", verdict.open_volume},
               {"witness", verdict.witness}};
    }
    if (verdict.method == "conformal") {
      entry["p"] = real(verdict.quantile);
      entry["l"] = verdict.order;
      entry["epsilon"] = verdict.epsilon;
      entry["beta"] = verdict.beta;
      entry["attempt"] = verdict.attempt;
      entry["tightest_epsilon"] = verdict.tightest_epsilon;
    }
  }
  json["seconds"] = ordered_json::object();
  for (const auto& [name, seconds] : record.timing) json["seconds"][name] = seconds;
  EvaluationSummary e = record.evaluation;
  json["mse_train"] = real(e.mse_train);
  json["mse_test"] = real(e.mse_test);
  json["mse_validation"] = real(e.mse_validation);
  json["sd_train"] = real(e.sd_train);
  json["sd_test"] = real(e.sd_test);
  json["dtw_train"] = real(e.dtw_train);
  json["dtw_test"] = real(e.dtw_test);
  json["dtw_independent_test"] = real(e.dtw_independent_test);
  json["safe_area"] = real(e.safe_area);
  json["true_safe_area"] = real(e.true_safe_area);
  json["safe_area_ratio"] = real(e.safe_area_ratio);
  json["disturbance_margin"] = real(record.certificate.disturbance_margin);
  json["convergence_radius"] = real(record.certificate.convergence_radius);
  json["float32_error"] = real(record.certificate.float32_error);
  json["rounds"] = record.checkpoint ? record.checkpoint->round : 0;
  json["weight_hash"] = record.certificate.weight_hash;
  json["statement"] = record.certificate.statement;
  const ThreadCounts threads = thread_counts();
  json["threads"] = {{"loops", threads.loops}, {"aten", threads.aten}, {"blas", nullptr}};
  if (threads.blas) json["threads"]["blas"] = *threads.blas;
  json["run"] = path;
  return json.dump();
}

}  // namespace s2nnds
