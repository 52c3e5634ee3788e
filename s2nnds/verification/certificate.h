// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/conditions/condition.h"
#include "s2nnds/core/enum_names.h"
#include "s2nnds/core/options.h"

namespace s2nnds {

// The guarantees that a run can reach, in increasing strength; guarantee_of (guarantee.h) decides which.
enum class Guarantee {
  none,       // nothing is claimed
  sampled,    // no violation at any of the samples
  conformal,  // each condition holds on all but a share epsilon of its region, with confidence 1 - beta
  proved,     // the conditions hold on the whole workspace
  invariant,  // proved, and {B <= 0} lies inside the workspace and contains X0: all motions in it are safe
};
template <>
struct EnumNames<Guarantee> {
  static constexpr std::string_view what = "guarantee";
  static constexpr auto names =
      std::to_array<std::string_view>({"none", "sampled", "conformal", "proved", "invariant"});
};

// How conditions are checked.
enum class Method {
  sampled,    // at i.i.d. samples (verify_sampled)
  conformal,  // by split conformal calibration (verify_conformal)
  // By branch and bound over the whole workspace (prove).
  proof
};
template <>
struct EnumNames<Method> {
  static constexpr std::string_view what = "method";
  static constexpr auto names = std::to_array<std::string_view>({"sampled", "conformal", "proof"});
};

// What a method says of a condition: `passed` or `failed` of samples and conformal calibration, the others of
// a proof.
enum class Verdict {
  passed,     // sampled: no violation; conformal: the quantile p is not a violation
  failed,     // the opposite, or the condition's region was never hit
  proved,     // holds everywhere
  refuted,    // a point certainly violates it
  undecided,  // neither was shown within the limits
};
template <>
struct EnumNames<Verdict> {
  static constexpr std::string_view what = "verdict";
  static constexpr auto names =
      std::to_array<std::string_view>({"passed", "failed", "proved", "refuted", "undecided"});
};

// What one method found out about one condition.
struct ConditionVerdict {
  Condition condition = Condition::lyapunov_positive;  // which condition this is about
  Method method = Method::sampled;                     // how it was checked
  Verdict verdict = Verdict::undecided;                // what came out
  std::int64_t samples = 0;     // sampled, conformal: points where the condition applied
  std::int64_t violations = 0;  // sampled, conformal: those of them that violate it
  std::int64_t seed = 0;        // of the sampling stream
  double worst = 0.0;           // largest residual seen; proof: of the witness, a lower bound; 0 if none
  double epsilon = 0.0;         // conformal: P(rho <= p) >= 1 - epsilon with confidence 1 - beta
  // Conformal: this condition's share of ConformalOptions::beta at this attempt, in (0, 1).
  double beta = 0.0;
  std::int64_t attempt = 0;       // conformal: which attempt on this run this was (beta is spent on each)
  std::int64_t order = 0;         // conformal: l
  double quantile = 0.0;          // conformal: p
  double tightest_epsilon = 1.0;  // conformal: the least epsilon at which p <= 0 (Clopper-Pearson)
  std::int64_t boxes = 0;         // proof: boxes examined
  std::int64_t open_boxes = 0;    // proof: boxes left over
  double open_volume = 0.0;       // proof: their volume, normalised length^n
  std::vector<double> witness;    // refuted: a point [n] that violates the condition, normalised
  std::string reason;             // proof, undecided: why no box was examined, where that is so
  double seconds = 0.0;           // wall clock

  void visit(FieldVisitor& v);  // names each field once, see FieldVisitor
};

// What must be proved besides the conditions. The conditions speak of V and Vdot away from the goal alone;
// the first two say that the goal is an equilibrium and the least point of V. The others: before {B <= 0} is
// known to be invariant.
struct SideConditions {
  bool goal_is_equilibrium = false;        // f(0) = 0, exactly
  bool lyapunov_vanishes_at_goal = false;  // V(0) = 0, exactly
  bool goal_is_safe = false;               // B(0) <= 0
  bool initial_in_workspace = false;       // X0 lies in X

  bool goal_holds() const { return goal_is_equilibrium && lyapunov_vanishes_at_goal; }  // the first two
  bool hold() const { return goal_holds() && goal_is_safe && initial_in_workspace; }    // all of them
  void visit(FieldVisitor& v);  // names each field once
};

// What is known of the motion as a robot executes it (executed_motion.h), in normalised units. Besides the
// guarantee, which speaks of x' = f(x).
struct ExecutionCertificate {
  std::string model;       // how it is executed, in words; "" where only the ideal motion was looked at
  std::string reason;      // why nothing was examined, where that is so
  bool invariant = false;  // the executed motion keeps {B <= 0} invariant
  double speed = 1.0;      // factor on f in the model
  double convergence_radius = 0.0;  // of the ball that it then converges to; infinite: not shown
  double most_command = 0.0;        // above every command
  // Certified factors on f, where they were looked for (most_speed > 0), and above every command at the
  // largest.
  double least_speed = 0.0, most_speed = 0.0, most_speed_command = 0.0;
  bool shielded = false;                        // any velocities are safe behind the Shield with
  double shield_band = 0.0, shield_cone = 0.0;  // these figures and most_command
  double damping = 0.0;  // N s/m, of the arm that the pushes are about; 0: none were looked for
  double least_push =
      0.0;  // N s: at no sample of the training demonstrations a smaller one leaves the safe set

  void visit(FieldVisitor& v);  // names each field once
};

// What is known of how the orientation follows, where poses move (networks/orientation_law.h). It counts only beside the
// guarantee `invariant`.
struct OrientationCertificate {
  bool proved = false;         // |psi| + initial_error < pi on {B <= 0}
  double bound = 0.0;          // rad: |psi| is below it on {B <= 0}; 0: not shown
  double initial_error = 0.0;  // rad: the largest |e| of a start that is spoken of
  double rate = 0.0;           // k, 1/s
  std::int64_t boxes = 0;      // examined
  std::string reason = {};     // why it was not proved; "" if it was, and where nothing turns
  std::string tool = {};       // by whose sweep the obstacle was grown, in words; "": none
  // Whether the tool touches nothing of the obstacle: turned as far as it may be, its sweep covers it.
  bool tool_clear = false;

  void visit(FieldVisitor& v);  // names each field once
};

// What is known of all motions of a projected f (stability.h), whatever the conditions' verdicts are: that they converge
// to the goal from anywhere in R^n.
struct StabilityCertificate {
  bool proved = false;  // it is so
  double decay =
      0.0;  // kappa, 1 / normalised time: V falls at least as fast as e^(-kappa t); 0: f is not projected
  double lipschitz = 0.0;   // L: above the Lipschitz constant of phi(x) - x, V = |phi|^2
  double overshoot = 0.0;   // (1 + L) / (1 - L): |x(t)| <= overshoot e^(-kappa t / 2) |x(0)|; 0: not proved
  std::string reason = {};  // why it was not proved; "" if it was, and where f is not projected

  void visit(FieldVisitor& v);  // names each field once
};

// What is known of a run's networks, and how it was found out.
struct Certificate {
  Guarantee guarantee = Guarantee::none;  // the strongest that the verdicts support (guarantee_of)
  std::string weight_hash;                // of the networks that it speaks of
  std::string scope;                      // all that it depends on, as TOML (runs/certified_scope.h)
  std::string seal;                       // SHA-256 over everything else here but seconds
  std::int64_t attempts = 0;              // conformal verifications made of these weights
  double level_band = 0.0;                // eps_B
  double disturbance_margin = 0.0;        // largest certified |w| (normalised velocity); 0: not certified
  double convergence_radius = 0.0;        // of the ball (normalised) that motions under such w converge to
  double float32_error = 0.0;          // bound on the error of f evaluated in float32 (normalised velocity)
  double barrier_float32_error = 0.0;  // the same of B, in X: B <= 0 where B in float32 is at most minus this
  double barrier_float64_error = 0.0;  // and in double
  std::string statement;               // what holds, in a paragraph a roboticist can read
  std::vector<ConditionVerdict> conditions;  // of every method used, at most one a method and condition
  ExecutionCertificate execution;            // of the motion as executed, found by the last proof
  SideConditions side;                       // found by the last proof
  OrientationCertificate orientation;        // found by the last proof
  StabilityCertificate stability;            // found by the last check of any method

  void visit(FieldVisitor& v);  // names each field once
};

}  // namespace s2nnds
