// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/proof_source.h"

#include <algorithm>

namespace s2nnds {
namespace {

// That V decreases takes by far the most boxes: it is looked at last.
constexpr Condition kOrder[] = {
    Condition::lyapunov_positive, Condition::initial,          Condition::unsafe,
    Condition::containment,       Condition::barrier_decrease, Condition::lyapunov_decrease};

// Of f and V alone.
std::string hash_of_motion(const Networks& networks) { return weight_hash({networks.f, networks.V, {}}); }

}  // namespace

Counterexamples ProofSource::find(const Networks& networks, const SafetyProblem& problem, double level_band,
                                  std::uint64_t seed, std::int64_t round) {
  const ProofFunctions functions = ProofFunctions::of(networks);
  RandomStream random(seed, "proof source", round);
  Counterexamples found;
  for (Condition condition : kOrder) {
    if (condition == Condition::lyapunov_decrease) {
      if (found.total() > 0 || decreasing_ == hash_of_motion(networks)) continue;
    }
    const ConditionProof proof = prove_condition(condition, functions, problem, level_band, options_);
    const auto q = static_cast<std::size_t>(condition);
    found.points[q] = proof.samples(static_cast<std::size_t>(keep_), random);
    // Where it gave up, most open boxes are those that were not looked at.
    const std::int64_t violations =
        proof.witnesses.rows() > 0 ? proof.witnesses.rows() : proof.verdict.open_boxes;
    found.counts[q] = proof.is_proved() ? 0 : std::max<std::int64_t>(1, violations);
    found.samples[q] = proof.verdict.boxes;
    if (condition == Condition::lyapunov_decrease && proof.is_proved())
      decreasing_ = hash_of_motion(networks);
  }
  return found;
}

}  // namespace s2nnds
