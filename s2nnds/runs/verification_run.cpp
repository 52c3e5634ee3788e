// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/verification_run.h"

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/statement.h"
#include "s2nnds/verification/disturbance_margin.h"
#include "s2nnds/verification/executed_motion.h"
#include "s2nnds/verification/guarantee.h"
#include "s2nnds/verification/level_distance.h"
#include "s2nnds/verification/orientation_bound.h"
#include "s2nnds/verification/rounding_error.h"
#include "s2nnds/verification/stability.h"

namespace s2nnds {
namespace {

constexpr const char* kNotInvariant = "the motion of the position is not proved to be invariant";

// With f in either precision of an exported header.
ExecutionModel model_of(const PreparedRun& setup, const Certificate& certificate) {
  return execution_model(setup.config.execution, setup.data.frame, certificate.float32_error);
}

void verify_executed(const PreparedRun& setup, const ProofFunctions& functions, RunRecord& record) {
  Certificate& certificate = record.certificate;
  const ExecutionModel model = model_of(setup, certificate);
  ExecutionCertificate& found = certificate.execution;
  const ExecutedMotion executed = prove_executed(functions, setup.problem, model);
  found.model = execution_in_words(setup.config.execution, setup.data.frame);
  found.reason = executed.reason;
  record.timing.execution = executed.seconds;
  found.speed = setup.config.execution.speed;
  found.invariant = executed.invariant;
  found.convergence_radius = executed.convergence_radius;
  found.most_command = executed.most_command;
  if (!executed.invariant) return;
  const Shield shield = prove_shield(functions, setup.problem, model);
  found.shielded = shield.certified;
  found.shield_band = shield.band;
  found.shield_cone = shield.cone;
}

// Of an arm that tracks velocities, xdot = f(x) + e with M edot = F - D e, a push J moves the arm by J / D
// beside what f does. Where it is short and M / D is, that is a jump, which stays in the safe set if that
// reaches that far.
void find_pushes(const PreparedRun& setup, const ProofFunctions& functions, RunRecord& record) {
  const ExecutionOptions& options = setup.config.execution;
  const double metres = metres_per_normalised(options, setup.data.frame);
  const Points x = stack_positions(setup.train());
  const Vector push = options.damping * metres * LevelDistance(functions, setup.problem).below(x);
  record.pushes.resize(x.rows(), x.cols() + 1);
  record.pushes << x, push;
  record.certificate.execution.damping = options.damping;
  record.certificate.execution.least_push = push.minCoeff() * (1.0 - 1e-12);
}

// How the orientation follows, for a run of poses.
OrientationCertificate verify_orientation(const PreparedRun& setup, const RunRecord& record,
                                          const ProofFunctions& functions, bool invariant,
                                          const BranchLimits& limits) {
  OrientationCertificate found;
  if (!setup.data.frame.has_orientation()) return found;
  const ToolOptions& tool = setup.config.problem.tool;
  if (!tool.is_none()) found.tool = in_words(tool, setup.data.frame.unit);
  if (!record.orientation || !invariant) {
    found.reason = invariant ? "no law was fitted" : kNotInvariant;
  } else {
    const OrientationBound bound =
        prove_orientation_bound(*record.orientation, functions, setup.problem, limits);
    found.proved = bound.proved;
    found.bound = bound.bound;
    found.initial_error = record.orientation->initial_error;
    found.rate = record.orientation->rate;
    found.boxes = bound.boxes;
    found.reason = bound.reason;
  }
  const double turned = (found.bound + found.initial_error) * (180.0 / M_PI) * (1.0 + 1e-12);
  found.tool_clear =
      !tool.is_none() && invariant && (tool.turn == 0.0 || (found.proved && turned <= tool.turn));
  return found;
}

// The proof's verdicts; side conditions, margins and open boxes go into the record.
std::vector<ConditionVerdict> verify_by_proof(const PreparedRun& setup, RunRecord& record,
                                              const VerificationOptions& options,
                                              const ProofProgress& progress, ProofCovers* covers) {
  Certificate& certificate = record.certificate;
  const ProofFunctions functions = ProofFunctions::of(record.networks);
  ProofOptions limits = options.proof;
  limits.keep_tree = covers != nullptr;
  const ProofResult result = prove(functions, setup.problem, certificate.level_band, limits, progress);
  if (covers != nullptr && result.guarantee == Guarantee::invariant) {
    for (const ConditionProof& proof : result.conditions) {
      if (proof.verdict.boxes > 0)
        covers->emplace_back(to_string(proof.verdict.condition), proof.tree.bytes());
    }
  }
  record.open_boxes.clear();
  for (const ConditionProof& proof : result.conditions) {
    if (proof.open_lower.rows() == 0) continue;
    Points corners(proof.open_lower.rows(), 2 * proof.open_lower.cols());
    corners << proof.open_lower, proof.open_upper;
    record.open_boxes.emplace_back(to_string(proof.verdict.condition), corners);
  }
  certificate.side = result.side;
  certificate.disturbance_margin = certificate.convergence_radius = 0.0;
  certificate.execution = {};
  record.pushes = {};
  if (result.guarantee == Guarantee::invariant) {
    const DisturbanceMargin margin = disturbance_margin(functions, setup.problem);
    certificate.disturbance_margin = margin.margin;
    certificate.convergence_radius = margin.convergence_radius;
    certificate.float32_error = float32_error(record.networks.f, setup.problem.workspace);
    record.timing.disturbance_margin = margin.seconds;
    if (!setup.config.execution.is_ideal()) verify_executed(setup, functions, record);
    if (setup.config.execution.damping > 0.0) find_pushes(setup, functions, record);
  }
  certificate.orientation =
      verify_orientation(setup, record, functions, result.guarantee == Guarantee::invariant, options.proof);
  record.timing.proof = result.seconds;
  return result.verdicts();
}

std::vector<ConditionVerdict> verdicts_by(Method method, const PreparedRun& setup, RunRecord& record,
                                          const VerificationOptions& options, const ProofProgress& progress,
                                          ProofCovers* covers) {
  Certificate& certificate = record.certificate;
  switch (method) {
    case Method::sampled:
      return verify_sampled(record.networks, setup.problem, certificate.level_band, options.sampled,
                            record.seed);
    case Method::conformal: {
      auto verdicts = verify_conformal(record.networks, setup.problem, certificate.level_band,
                                       options.conformal, record.seed, certificate.attempts + 1);
      ++certificate.attempts;  // a refused call is no attempt
      return verdicts;
    }
    case Method::proof:
      return verify_by_proof(setup, record, options, progress, covers);
  }
  fail("method: found the value {}, expected 0 to 2", static_cast<int>(method));
}

// What a proof says besides the guarantee `invariant` falls with it, as by a later counterexample.
void keep_what_invariance_carries(RunRecord& record) {
  Certificate& certificate = record.certificate;
  if (certificate.guarantee == Guarantee::invariant) return;
  certificate.disturbance_margin = certificate.convergence_radius = 0.0;
  certificate.execution = {};
  if (OrientationCertificate& turning = certificate.orientation; turning.proved || turning.tool_clear)
    turning = {.reason = kNotInvariant, .tool = turning.tool};
  record.pushes = {};
}

double& seconds_of(Method method, RunTiming& timing) {
  return method == Method::sampled     ? timing.verification_sampled
         : method == Method::conformal ? timing.verification_conformal
                                       : timing.verification_proof;
}

}  // namespace

void verify(const PreparedRun& setup, RunRecord& record, Method method, const VerificationOptions& options,
            const ProofProgress& progress, ProofCovers* covers) {
  const Stopwatch watch;
  Certificate& certificate = record.certificate;
  // What was found of other weights or of another problem is void, and so is what was changed since. The
  // conformal attempts go on being counted.
  if (!is_intact(setup, record)) {
    const std::int64_t attempts = certificate.attempts;
    certificate = {};
    certificate.attempts = attempts;
    record.problem = new_record(setup, "").problem;
    record.pushes = {};
  }
  certificate.weight_hash = weight_hash(record.networks);
  certificate.level_band = setup.config.training.level_band;
  if (!(certificate.barrier_float32_error > 0.0)) {  // nor known from another method
    certificate.barrier_float32_error = float32_error(record.networks.B, setup.problem.workspace);
    certificate.barrier_float64_error = float64_error(record.networks.B, setup.problem.workspace);
  }
  certificate.stability = prove_stability(record.networks);
  const std::vector<ConditionVerdict> verdicts =
      verdicts_by(method, setup, record, options, progress, covers);
  std::erase_if(certificate.conditions, [&](const ConditionVerdict& old) { return old.method == method; });
  certificate.conditions.insert(certificate.conditions.end(), verdicts.begin(), verdicts.end());
  certificate.guarantee = guarantee_of(certificate.conditions, certificate.side, setup.problem);
  keep_what_invariance_carries(record);
  certificate.statement = guarantee_statement(record);
  seal_certificate(setup, record);
  seconds_of(method, record.timing) = watch.seconds();
}

void find_certified_speeds(const PreparedRun& setup, RunRecord& record) {
  Certificate& certificate = record.certificate;
  check(!setup.config.execution.is_ideal(),
        "speed: the run's configuration has no [execution], expected the delays and errors that speeds are "
        "limited by");
  check(certificate.guarantee == Guarantee::invariant,
        "speed: found the guarantee {}, expected invariant: speeds are certified for a safe set that is",
        to_string(certificate.guarantee));
  const SpeedRange range =
      certified_speeds(ProofFunctions::of(record.networks), setup.problem, model_of(setup, certificate));
  certificate.execution.least_speed = range.least;
  certificate.execution.most_speed = range.most;
  certificate.execution.most_speed_command = range.most_command;
  certificate.statement = guarantee_statement(record);
  seal_certificate(setup, record);
}

void verify_as_configured(const PreparedRun& setup, RunRecord& record, const ProofProgress& progress) {
  const VerificationOptions& options = setup.config.verification;
  const Method configured = options.method.value_or(Method::proof);
  verify(setup, record, Method::sampled, options);
  if (configured == Method::proof) verify(setup, record, Method::proof, options, progress);
  // A proof says more than conformal calibration, which takes longer.
  const bool proved = record.certificate.guarantee == Guarantee::invariant;
  if (configured != Method::sampled && !proved) verify(setup, record, Method::conformal, options);
}

}  // namespace s2nnds
