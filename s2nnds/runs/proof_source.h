// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "s2nnds/training/counterexample.h"
#include "s2nnds/verification/prover.h"
#include "s2nnds/verification/rounding_error.h"

namespace s2nnds {

// The prover as a source of counterexamples: boxes that it cannot prove, and points that it refutes, go back
// into training. Nothing found means that the conditions are proved on the whole workspace, and that Bdot < 0 on the band
// withstands disturbances as large as the error of f in float32, so that the guarantee speaks of the exported policy
// too. Whether V decreases, and in space whether B does, is asked only once all before it is proved. What was proved is
// not asked again while the networks that it concerns stay as they were.
class ProofSource : public CounterexampleSource {
 public:
  // `options`: limits of each proof; `keep`: points of each condition that are handed on, at most.
  explicit ProofSource(const ProofOptions& options, std::int64_t keep = counterexamples_kept)
      : options_(options), keep_(keep) {}
  bool only_when_clean() const override { return true; }
  Counterexamples find(const Networks& networks, const SafetyProblem& problem, double level_band,
                       std::uint64_t seed, std::int64_t round) override;

 private:
  ConditionProof prove(Condition condition, const Networks& networks, const SafetyProblem& problem,
                       double level_band);

  ProofOptions options_;
  Float32Error field_error_;  // of f
  std::int64_t keep_;         // points of each condition that are handed on
  std::array<std::string, condition_count>
      proved_;  // hashes of the networks for which each one was proved last
};

}  // namespace s2nnds
