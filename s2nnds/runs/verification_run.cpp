#include "s2nnds/runs/verification_run.h"

#include "s2nnds/core/check.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/runs/statement.h"

namespace s2nnds {
namespace {

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
    record.timing.disturbance_margin = margin.seconds;
  }
  record.timing.proof = result.seconds;
  return verdicts;
}

}  // namespace

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
  (method == "sampled"     ? record.timing.verification_sampled
   : method == "conformal" ? record.timing.verification_conformal
                           : record.timing.verification_proof) = watch.seconds();
}

}  // namespace s2nnds
