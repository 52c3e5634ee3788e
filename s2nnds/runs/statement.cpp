// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/statement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "s2nnds/data/orientation.h"
#include "s2nnds/runs/user_units.h"

namespace s2nnds {
namespace {

std::string number(double value) { return fmt::format("{:.4g}", value); }

// Four digits that are not more than the value, >= 0, was.
std::string decimal_down(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return number(value);
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 3.0);
  return number(std::floor(value / unit * (1.0 - 1e-12)) * unit);
}

std::string all_conditions_in_words(const RunRecord& record) {
  return fmt::format(
      "V > 0 and V decreases along motions everywhere but at the goal, B <= 0 on the initial set, B > 0 on "
      "the "
      "unsafe set{}, and B decreases where |B| <= {}",
      record.problem.containment > 0 ? " and on the workspace's outer margin" : "",
      number(record.certificate.level_band));
}

// What all samples of one method say together.
struct SampleFigures {
  std::int64_t samples = 0, attempt = 0;
  double epsilon = 0.0, beta = 0.0;  // the largest, and the sum
};

SampleFigures figures_of(Method method, const Certificate& certificate) {
  SampleFigures all;
  for (const ConditionVerdict& verdict : certificate.conditions) {
    if (verdict.method != method) continue;
    all.samples = std::max(all.samples, verdict.samples);
    all.attempt = std::max(all.attempt, verdict.attempt);
    all.epsilon = std::max(all.epsilon, verdict.epsilon);
    all.beta += verdict.beta;
  }
  return all;
}

std::string names_of(Verdict wanted, const Certificate& certificate) {
  std::string names;
  for (const Condition condition : all_conditions) {
    const bool found = std::any_of(certificate.conditions.begin(), certificate.conditions.end(),
                                   [&](const ConditionVerdict& verdict) {
                                     return verdict.condition == condition && verdict.verdict == wanted;
                                   });
    if (found) names += fmt::format("{}{}", names.empty() ? "" : ", ", to_string(condition));
  }
  return names;
}

// " (why)" where a verdict comes with its reason.
std::string reason_of(Verdict wanted, const Certificate& certificate) {
  for (const ConditionVerdict& verdict : certificate.conditions) {
    if (verdict.verdict == wanted && !verdict.reason.empty()) return fmt::format(" ({})", verdict.reason);
  }
  return "";
}

std::string disturbance_in_words(const RunRecord& record) {
  const Certificate& c = record.certificate;
  const UserUnits units(record);
  if (!(c.disturbance_margin > 0)) return " No margin against disturbances was certified.";
  std::string text = fmt::format(
      " Motions from the safe set also stay in it under any disturbance xdot = f(x) + w with |w| <= {}",
      units.speed(c.disturbance_margin));
  if (c.convergence_radius < record.problem.workspace.half_widths().minCoeff()) {
    text += fmt::format(", and then converge to a ball of radius {} around the goal",
                        units.length(c.convergence_radius));
  }
  return text + fmt::format(". Evaluating f in float32 is wrong by at most {}, which this margin {}.",
                            units.speed(c.float32_error),
                            c.float32_error < c.disturbance_margin ? "covers" : "does NOT cover");
}

std::string executed_in_words(const RunRecord& record) {
  const ExecutionCertificate& executed = record.certificate.execution;
  if (executed.model.empty()) return "";
  std::string text = fmt::format(" As a robot executes it ({}), ", executed.model);
  if (!executed.invariant) {
    return text + fmt::format("the motion is NOT certified: that it stays in the safe set was not shown{}.",
                              executed.reason.empty() ? "" : fmt::format(" ({})", executed.reason));
  }
  const UserUnits units(record);
  text += fmt::format(
      "every motion that starts in the safe set, at rest until then or under way in it, stays in it, with f "
      "evaluated "
      "in double or float32; no command is faster than {}",
      units.speed(executed.most_command));
  if (executed.convergence_radius < record.problem.workspace.half_widths().minCoeff())
    text += fmt::format("; it converges to a ball of radius {} around the goal",
                        units.length(executed.convergence_radius));
  else
    text += "; that it comes near the goal was not shown";
  text += ".";
  if (const std::string speeds = certified_speeds_in_words(record); !speeds.empty())
    text += fmt::format(" Staying in the safe set is {}.", speeds);
  return text;
}

std::string pushes_in_words(const RunRecord& record) {
  const ExecutionCertificate& executed = record.certificate.execution;
  if (!(executed.damping > 0.0)) return "";
  return fmt::format(
      " A push of at most {} N s takes an arm of damping {} N s/m out of the safe set from no sample of the "
      "training "
      "demonstrations, if it is over, and the arm tracks velocities again, before the motion has moved on.",
      number(executed.least_push), number(executed.damping));
}

std::string details(const RunRecord& record) {
  const Certificate& certificate = record.certificate;
  switch (certificate.guarantee) {
    case Guarantee::none:
      return "";
    case Guarantee::sampled:
      return fmt::format(
          " Checked: {}. The samples are uniform over the workspace, fewer in the smaller regions; seed {}.",
          all_conditions_in_words(record), record.seed);
    case Guarantee::conformal: {
      const SampleFigures all = figures_of(Method::conformal, certificate);
      return fmt::format(
          " The conditions are: {}. This was attempt {}, with {} fresh samples a region, seed {}. {} It is a "
          "statement about random points, one at a time: a violation on a smaller set is not excluded, so it "
          "does not prove that every motion is safe.",
          all_conditions_in_words(record), all.attempt, all.samples, record.seed, kAttemptsCounted);
    }
    case Guarantee::proved:
    case Guarantee::invariant:
      return fmt::format(
          " Proved: f and V are 0 at the goal, {}. The proof holds in exact arithmetic for the networks with "
          "these double-precision "
          "weights; its own rounding is covered.{}",
          all_conditions_in_words(record),
          certificate.guarantee == Guarantee::invariant
              ? disturbance_in_words(record) + executed_in_words(record) + pushes_in_words(record)
              : "");
  }
  return "";
}

// A point that a proof knows to violate a condition is told whatever else is guaranteed.
std::string refutations(const RunRecord& record) {
  std::string text;
  for (const ConditionVerdict& verdict : record.certificate.conditions) {
    if (verdict.verdict != Verdict::refuted) continue;
    text += fmt::format(" The proof REFUTED {}: it is violated at {}.", to_string(verdict.condition),
                        UserUnits(record).position(verdict.witness));
  }
  return text;
}

// What the words above speak of: without it they say nothing about a place in the room.
std::string coordinates(const RunRecord& record) {
  const UserUnits units(record);
  if (!units.in_data()) return " Coordinates are normalised, with the goal at the origin.";
  const Frame& frame = record.data.frame;
  return fmt::format(
      " Positions are those of the data{}, in {}: the goal is {}, the workspace {}, the unsafe set {}, the "
      "initial set "
      "{}.",
      frame.name.empty() ? "" : fmt::format(" (frame {})", frame.name), units.name(),
      frame.position_text(frame.goal), units.workspace(), record.problem.unsafe, record.problem.initial);
}

// What the proof is of where a phase belongs to the state.
std::string phase_in_words(const RunRecord& record) {
  const Frame& frame = record.data.frame;
  if (!frame.has_phase()) return "";
  return fmt::format(
      " The state is (x, s): x is the position, s a number that the controller starts at {} and integrates, "
      "s' = f_s(x, s), beside x' = f_x(x, s); it stands for the part of the path that is left, and is 0 at "
      "the goal. The unsafe set is one of x, whatever s is; V, B, the workspace and margins are of (x, s).",
      UserUnits(record).in_data() ? fmt::format("{} {}", number(frame.phase_start), UserUnits(record).name())
                                  : number(frame.phase_start / frame.position_scale));
}

// What the proof of stability says beyond its sentence.
std::string stability_details(const RunRecord& record) {
  const StabilityCertificate& found = record.certificate.stability;
  if (!found.proved) return "";
  return fmt::format(
      " Of stability: f is the network's velocity projected on those along which V falls so fast, and V = "
      "|phi(x)|^2, "
      "where phi(x) - x has a Lipschitz constant below {:.6g}, so that phi is one-to-one and V has no other "
      "place of "
      "rest; a motion's distance from the goal is at most {:.4g} exp(-{} t) times that at its start. It "
      "holds in exact "
      "arithmetic for the networks with these double-precision weights, whatever is said of the obstacle: a "
      "motion "
      "that converges may meet it.",
      found.lipschitz * (1.0 + 1e-5), found.overshoot * (1.0 + 1e-3),
      decimal_down(0.5 * found.decay / record.data.frame.time_scale()));
}

// Hundredths of degrees, rounded so that what is said of them is true.
double degrees_up(double radians) { return std::ceil(100.0 * degrees(radians) + 1e-6) / 100.0; }
double degrees_down(double radians) { return std::floor(100.0 * degrees(radians) - 1e-6) / 100.0; }

// What is proved of the orientation, exactly.
std::string orientation_details(const RunRecord& record) {
  const OrientationCertificate& found = record.certificate.orientation;
  if (!found.proved || record.certificate.guarantee != Guarantee::invariant) return "";
  const Frame& frame = record.data.frame;
  const Eigen::Vector4d q = to_order(frame.goal_orientation, frame.quaternion_order);
  const std::string goal = fmt::format("{:.5g}, {:.5g}, {:.5g}, {:.5g}", q[0], q[1], q[2], q[3]);
  const double room = degrees_down(M_PI - found.bound), covered = degrees_down(found.initial_error);
  return fmt::format(
      " Of the orientation: with r = log(q_goal^-1 q) and e = r - psi(p), the law makes e fall as exp(-{} "
      "t), t "
      "in s, whatever the position does. Proved: |psi(p)| < {} degrees on the safe set, which with |e| <= {} "
      "degrees at the start stays below 180 degrees{}, so that r is smooth along the motion. The goal's "
      "orientation q_goal ({}) is ({}). Excluded are starts with a larger |e|, among them all that are "
      "turned "
      "from the goal by 180 degrees: no continuous law on all orientations has one that attracts every "
      "other. "
      "This holds for an orientation that turns as commanded, in continuous time and exact arithmetic; of "
      "errors in following nothing is said.",
      found.rate, degrees_up(found.bound), covered,
      room > covered ? fmt::format(" (and so it would from |e| <= {})", room) : "", frame.quaternion_order,
      goal);
}

std::string tool_sentence(const OrientationCertificate& found) {
  if (found.tool.empty()) return "";
  if (!found.tool_clear) return fmt::format(" Nothing is guaranteed of the tool, {}.", found.tool);
  return fmt::format(
      " The tool, {} in the frame that turns, touches nothing of the obstacle either: the unsafe set is the "
      "obstacle grown by what the tool sweeps.",
      found.tool);
}

}  // namespace

std::string certified_speeds_in_words(const RunRecord& record) {
  const ExecutionCertificate& executed = record.certificate.execution;
  if (!(executed.most_speed > 0.0)) return "";
  const std::string from = executed.least_speed > 0.0 ? number(executed.least_speed) : "0 (excluded)";
  if (std::isinf(executed.most_speed))
    return fmt::format("certified from {} times the demonstrated speed on", from);
  return fmt::format("certified from {} to {} times the demonstrated speed (up to {})", from,
                     number(executed.most_speed), UserUnits(record).speed(executed.most_speed_command));
}

std::string guarantee_sentence(const RunRecord& record) {
  const Certificate& certificate = record.certificate;
  switch (certificate.guarantee) {
    case Guarantee::none: {
      if (certificate.conditions.empty()) return "Nothing is guaranteed: nothing was checked.";
      for (const auto& [verdict, words] :
           {std::pair{Verdict::refuted, "The proof refuted"}, std::pair{Verdict::failed, "Samples violate"},
            std::pair{Verdict::undecided, "The proof left open"}}) {
        const std::string names = names_of(verdict, certificate);
        if (!names.empty())
          return fmt::format("Nothing is guaranteed. {}: {}{}.", words, names,
                             reason_of(verdict, certificate));
      }
      if (!certificate.side.goal_holds())
        return "Nothing is guaranteed. It is not certain that f and V are exactly 0 at the goal.";
      return "Nothing is guaranteed.";
    }
    case Guarantee::sampled:
      return fmt::format(
          "No violation of any condition was found at {} uniform samples. That is no statement about the "
          "points between them.",
          figures_of(Method::sampled, certificate).samples);
    case Guarantee::conformal: {
      const SampleFigures all = figures_of(Method::conformal, certificate);
      return fmt::format(
          "With confidence 1 - {}, each condition holds on all but a share of at most epsilon = {} of its "
          "region.",
          number(all.beta), number(all.epsilon));
    }
    case Guarantee::proved:
      return "All conditions are proved for every point of the workspace. It is not proved that {B <= 0} "
             "lies "
             "inside the workspace, so a motion is covered only while it stays inside.";
    case Guarantee::invariant:
      if (record.data.frame.has_phase())
        return "Proved: every motion (x, s)' = f(x, s), s a phase that the controller keeps, that starts in "
               "the safe set {B <= 0} stays in it for ever, never touches the unsafe set with x, and "
               "converges to the goal.";
      return "Proved: every motion xdot = f(x) that starts in the safe set {B <= 0} stays in it for ever, "
             "never "
             "touches the unsafe set, and converges to the goal.";
  }
  return "";
}

std::string stability_sentence(const RunRecord& record) {
  const StabilityCertificate& found = record.certificate.stability;
  if (found.decay == 0.0) return "";
  if (!found.proved) return fmt::format("Stability is NOT proved: {}.", found.reason);
  return fmt::format(
      "Stability is proved: every motion of x' = f(x), from any state, converges to the goal (V falls at "
      "least as "
      "fast as exp(-{} t), t in s).",
      decimal_down(found.decay / record.data.frame.time_scale()));
}

std::string orientation_sentence(const RunRecord& record) {
  if (!record.data.frame.has_orientation()) return "";
  const Certificate& certificate = record.certificate;
  const OrientationCertificate& found = certificate.orientation;
  const std::string tool = tool_sentence(found);
  if (!found.proved || certificate.guarantee != Guarantee::invariant) {
    return fmt::format("Nothing is guaranteed of the orientation{}.{}",
                       found.reason.empty() ? "" : fmt::format(": {}", found.reason), tool);
  }
  return fmt::format(
      "Its orientation converges to the goal's from every start in the safe set with an orientation error "
      "|e| of at "
      "most {} degrees; starts with a larger one are excluded.{}",
      degrees_down(found.initial_error), tool);
}

std::string guarantee_statement(const RunRecord& record) {
  const std::string turning = orientation_sentence(record);
  const std::string stable = stability_sentence(record);
  const std::string sentences = (stable.empty() ? "" : stable + " ") + guarantee_sentence(record) +
                                (turning.empty() ? "" : " " + turning);
  if (record.certificate.guarantee == Guarantee::none)
    return sentences + stability_details(record) + refutations(record);
  return sentences + phase_in_words(record) + stability_details(record) + details(record) +
         orientation_details(record) + refutations(record) + coordinates(record) +
         (record.certificate.execution.invariant
              ? " This is about a point of the robot that moves as told above, not about its other parts."
              : " This is about the kinematic motion of a point, not about a robot's tracking error.");
}

}  // namespace s2nnds
