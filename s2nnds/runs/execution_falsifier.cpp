// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/execution_falsifier.h"

#include <algorithm>

#include "s2nnds/verification/executed_motion.h"

namespace s2nnds {
Counterexamples ExecutionFalsifier::find(const Networks& networks, const SafetyProblem& problem, double,
                                         std::uint64_t seed, std::int64_t round) {
  const ProofFunctions functions = ProofFunctions::of(networks);
  ExecutionModel model = model_;
  model.field_error = field_error_.of(networks.f, problem.workspace);
  const BranchResult result = prove_executed_invariance(functions, problem, model, keep_);
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
