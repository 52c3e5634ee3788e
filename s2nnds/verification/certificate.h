#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/core/options.h"

namespace s2nnds {

// The guarantees a run can reach, in increasing strength (text in files and on the command line):
//   none -> sampled -> conformal -> proved (the conditions hold on the whole workspace) -> invariant (proved,
//   and {B <= 0} lies inside the workspace and contains X0: all its trajectories are safe and converge).
enum class Guarantee { none, sampled, conformal, proved, invariant };
std::string_view to_string(Guarantee guarantee);
Guarantee guarantee_from(std::string_view name);

// What one method found out about one condition.
struct ConditionVerdict {
  std::string condition;     // to_string(Condition)
  std::string method;        // sampled, conformal, proof
  std::string verdict;       // passed, failed (sampled, conformal); proved, refuted, undecided (proof)
  std::int64_t samples = 0;  // sampled, conformal: points where the condition applied
  std::int64_t violations = 0;
  std::int64_t seed = 0;  // of the sampling stream
  double worst = 0.0;     // largest residual seen
  double epsilon = 0.0;   // conformal: P(rho <= p) >= 1 - epsilon with confidence 1 - beta
  double beta = 0.0;
  std::int64_t attempt = 0;       // conformal: which attempt on this run this was (beta is spent on each)
  std::int64_t order = 0;         // conformal: l
  double quantile = 0.0;          // conformal: p
  double tightest_epsilon = 1.0;  // conformal: the least epsilon at which p <= 0 (Clopper-Pearson)
  std::int64_t boxes = 0;         // proof: boxes examined
  std::int64_t open_boxes = 0;    // proof: boxes left over
  double open_volume = 0.0;
  std::vector<double> witness;  // refuted: a point that violates the condition
  double seconds = 0.0;

  void visit(FieldVisitor& v);
};

struct Certificate {
  std::string guarantee = "none";
  std::string method;               // the last method that was run
  std::string weight_hash;          // of the networks that it speaks of
  std::int64_t attempts = 0;        // conformal verifications made of these weights
  double level_band = 0.0;          // eps_B
  double disturbance_margin = 0.0;  // largest certified |w| (normalised velocity); 0: not certified
  double convergence_radius = 0.0;  // of the ball (normalised) that motions under such w converge to
  double float32_error = 0.0;       // bound on the error of f evaluated in float32 (normalised velocity)
  std::string statement;            // what holds, in a paragraph a roboticist can read
  std::vector<ConditionVerdict> conditions;

  void visit(FieldVisitor& v);
};

}  // namespace s2nnds
