// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/proof_source.h"

#include <algorithm>
#include <utility>

namespace s2nnds {
namespace {

// That B and V decrease takes by far the most boxes: it is looked at last.
constexpr Condition kOrder[] = {
    Condition::lyapunov_positive, Condition::initial,          Condition::unsafe,
    Condition::containment,       Condition::barrier_decrease, Condition::lyapunov_decrease};

// The margin of what is certified is found by bisection afterwards, to a few per cent: a little room lets it cover the
// error of float32 as well.
constexpr double kRoom = 1.1;

// In the plane Bdot costs little.
bool is_costly(Condition condition, Eigen::Index dimension) {
  return condition == Condition::lyapunov_decrease ||
         (condition == Condition::barrier_decrease && dimension > 2);
}

// Of the networks that the condition concerns.
std::string hash_for(Condition condition, const Networks& networks) {
  switch (condition) {
    case Condition::lyapunov_positive:
      return weight_hash({{}, networks.V, {}});
    case Condition::lyapunov_decrease:
      return weight_hash({networks.f, networks.V, {}});
    case Condition::barrier_decrease:
      return weight_hash({networks.f, {}, networks.B});
    case Condition::initial:
    case Condition::unsafe:
    case Condition::containment:
      break;
  }
  return weight_hash({{}, {}, networks.B});
}

}  // namespace

ConditionProof ProofSource::prove(Condition condition, const Networks& networks, const SafetyProblem& problem,
                                  double level_band) {
  const ProofFunctions functions = ProofFunctions::of(networks);
  if (condition != Condition::barrier_decrease)
    return prove_condition(condition, functions, problem, level_band, options_);
  return prove_barrier_decrease(functions, problem, level_band,
                                kRoom * field_error_.of(networks.f, problem.workspace), options_);
}

Counterexamples ProofSource::find(const Networks& networks, const SafetyProblem& problem, double level_band,
                                  std::uint64_t seed, std::int64_t round) {
  RandomStream random(seed, "proof source", round);
  Counterexamples found;
  for (Condition condition : kOrder) {
    const auto q = static_cast<std::size_t>(condition);
    std::string hash = hash_for(condition, networks);
    if (proved_[q] == hash || (found.total() > 0 && is_costly(condition, problem.dimension()))) continue;
    const ConditionProof proof = prove(condition, networks, problem, level_band);
    found.points[q] = proof.samples(static_cast<std::size_t>(keep_), random);
    // Where it gave up, most open boxes are those that were not looked at.
    const std::int64_t violations =
        proof.witnesses.rows() > 0 ? proof.witnesses.rows() : proof.verdict.open_boxes;
    found.counts[q] = proof.is_proved() ? 0 : std::max<std::int64_t>(1, violations);
    found.samples[q] = proof.verdict.boxes;
    if (proof.is_proved()) proved_[q] = std::move(hash);
  }
  return found;
}

}  // namespace s2nnds
