#include "s2nnds/runs/statement.h"

#include <fmt/ranges.h>

#include <algorithm>

namespace s2nnds {
namespace {

std::string number(double value) { return fmt::format("{:.4g}", value); }

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

}  // namespace s2nnds
