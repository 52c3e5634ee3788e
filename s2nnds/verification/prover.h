// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "s2nnds/conditions/condition.h"
#include "s2nnds/core/random.h"
#include "s2nnds/verification/branch_and_bound.h"
#include "s2nnds/verification/certificate.h"
#include "s2nnds/verification/taylor_model.h"

namespace s2nnds {

// Limits of the proof of each condition; `max_seconds` is for the whole of what is to be proved.
struct ProofOptions : BranchLimits {
  // For the training loop: gives up early, with the boxes that are open by then.
  static ProofOptions fail_fast();
  void visit(FieldVisitor& v);  // names max_boxes and max_seconds
};

// f, V, B as the prover sees them.
struct ProofFunctions {
  std::shared_ptr<const TaylorFunction> f,  // vector field R^n -> R^n
      V,                                    // Lyapunov function R^n -> R
      B;                                    // barrier R^n -> R

  // Copies the networks' weights. Throws Error as NetworkFunction does.
  static ProofFunctions of(const Networks& networks);
  // Which of them has underflow that bounds over the workspace do not cover (rounding.h), in words; "" if none has.
  std::string beyond_range(const Box& workspace) const;
};

// `count` points [count, n], each uniform in one of the boxes [N, n]; none if there is no box.
Points points_in_boxes(const Points& lower, const Points& upper, std::size_t count, RandomStream& random);

// What the proof of one condition found out.
struct ConditionProof {
  ConditionVerdict verdict;  // proved, refuted or undecided, with box counts
  Points open_lower,  // [kept, n] lower corners of boxes left over, those with a certain violation first
      open_upper;     // [kept, n] their upper corners
  Points witnesses;   // [refuted, n] a point of each of these that violates the condition, the worst first
  double goal_cube = 0.0;  // Lyapunov conditions: proved by interval Jacobians for 0 < |x|_inf <= goal_cube
  // The boxes that proved it, of the workspace and for containment behind it of the lower and upper face of each
  // axis, where BranchLimits::keep_tree asked for them.
  BisectionTree tree;

  bool is_proved() const { return verdict.verdict == Verdict::proved; }  // on its whole region
  // `count` points [count, n] for training: the witnesses, then points drawn from the open boxes (where n > 3 from
  // those of the witnesses, if there are any). Empty if proved.
  Points samples(std::size_t count, RandomStream& random) const;
};

// What the proof of all conditions found out.
struct ProofResult {
  Guarantee guarantee = Guarantee::none;   // none, proved or invariant
  std::vector<ConditionProof> conditions;  // in the order of all_conditions
  SideConditions side;                     // what must hold besides
  double goal_cube = 0.0;  // Vdot < 0 was proved by interval Jacobians for 0 < |x|_inf <= goal_cube
  std::int64_t boxes = 0;  // examined, for all conditions
  double seconds = 0.0;    // wall clock

  // The proof of this condition.
  const ConditionProof& operator[](Condition condition) const;
  std::vector<ConditionVerdict> verdicts() const;  // of the conditions, in the same order
};

// Called after each level of the proof of the condition.
using ProofProgress = std::function<void(Condition, const BranchProgress&)>;

// Decides all conditions on the whole continuum of the workspace (condition.h), with `level_band` =
// eps_B >= 0. Sound in floating point: `proved` holds in exact arithmetic for the functions with exactly
// these double coefficients, and a witness violates its condition in exact arithmetic. Containment is proved
// on the workspace margin, if there is one, and on the workspace's boundary. Guarantee: `proved` if all
// conditions hold (containment only where the problem has a workspace margin); `invariant` if containment
// holds and the side conditions do. Where weights are so large or the workspace so wide that underflow is not covered
// (rounding.h), everything is undecided, with the reason in the verdict. Verdicts and box counts do not depend on the number
// of threads, unless the time limit strikes. Throws Error on functions or sets of different dimensions.
ProofResult prove(const ProofFunctions& functions, const SafetyProblem& problem, double level_band,
                  const ProofOptions& options = {}, const ProofProgress& progress = nullptr);
// The same for networks.
ProofResult prove(const Networks& networks, const SafetyProblem& problem, double level_band,
                  const ProofOptions& options = {}, const ProofProgress& progress = nullptr);

// One condition alone, in the same way.
ConditionProof prove_condition(Condition condition, const ProofFunctions& functions,
                               const SafetyProblem& problem, double level_band,
                               const ProofOptions& options = {}, const ProofProgress& progress = nullptr);

// barrier_decrease alone, for every motion xdot = f(x) + d with |d| <= disturbance (normalised velocity, >= 0).
ConditionProof prove_barrier_decrease(const ProofFunctions& functions, const SafetyProblem& problem,
                                      double level_band, double disturbance,
                                      const ProofOptions& options = {});

}  // namespace s2nnds
