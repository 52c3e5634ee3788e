#include "s2nnds/runs/proof_source.h"

namespace s2nnds {

Counterexamples ProofSource::find(const Networks& networks, const SafetyProblem& problem, double band,
                                  std::uint64_t seed, std::int64_t round) {
  const ProofResult result = prove(networks, problem, band, options_);
  RandomStream random(seed, "proof source", round);
  Counterexamples found;
  for (std::size_t q = 0; q < all_conditions.size(); ++q) {
    const ConditionProof& proof = result[all_conditions[q]];
    found.points[q] = proof.samples(static_cast<std::size_t>(keep_), random);
    found.counts[q] = proof.is_proved() ? 0 : std::max<std::int64_t>(1, proof.verdict.open_boxes);
    found.samples[q] = proof.verdict.boxes;
  }
  return found;
}

}  // namespace s2nnds
