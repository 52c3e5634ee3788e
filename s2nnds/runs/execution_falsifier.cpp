// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/execution_falsifier.h"

#include <algorithm>

#include "s2nnds/verification/disturbance_margin.h"
#include "s2nnds/verification/executed_motion.h"
#include "s2nnds/verification/rounding_error.h"

namespace s2nnds {
namespace {

// The margin is found by bisection afterwards, to a few per cent: a little room lets it cover the error as
// well.
constexpr double kRoom = 1.1;

}  // namespace

double ExecutionFalsifier::error_of(const Networks& networks, const Box& workspace) {
  const std::string field = weight_hash({networks.f, {}, {}});
  if (field != field_) error_ = float32_error(networks.f, workspace);
  field_ = field;
  return error_;
}

Counterexamples ExecutionFalsifier::find(const Networks& networks, const SafetyProblem& problem, double,
                                         std::uint64_t seed, std::int64_t round) {
  const ProofFunctions functions = ProofFunctions::of(networks);
  ExecutionModel model = model_;
  model.field_error = error_of(networks, problem.workspace);
  const BranchResult result =
      model_.is_ideal() ? prove_under_disturbance(functions, problem, kRoom * model.field_error, keep_)
                        : prove_executed_invariance(functions, problem, model, keep_);
  RandomStream random(seed, "float32 source", round);
  Counterexamples found;
  const auto q = static_cast<std::size_t>(Condition::barrier_decrease);
  found.samples[q] = result.boxes;
  if (result.proved) return found;
  found.counts[q] = std::max<std::int64_t>(1, result.open_boxes);
  found.points[q] =
      points_in_boxes(result.open_lower, result.open_upper, static_cast<std::size_t>(keep_), random);
  return found;
}

}  // namespace s2nnds
