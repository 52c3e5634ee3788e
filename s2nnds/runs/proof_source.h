// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/training/counterexample.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

// The prover as a source of counterexamples: boxes that it cannot prove, and points that it refutes, go back
// into training. Nothing found means that the conditions are proved on the whole workspace. Whether V
// decreases is asked only once all else is proved, and not again while f and V stay as they were.
class ProofSource : public CounterexampleSource {
 public:
  // `options`: limits of each proof; `keep`: points of each condition that are handed on, at most.
  explicit ProofSource(const ProofOptions& options, std::int64_t keep = counterexamples_kept)
      : options_(options), keep_(keep) {}
  bool only_when_clean() const override { return true; }
  Counterexamples find(const Networks& networks, const SafetyProblem& problem, double level_band,
                       std::uint64_t seed, std::int64_t round) override;

 private:
  ProofOptions options_;
  std::int64_t keep_;       // points of each condition that are handed on
  std::string decreasing_;  // hash of the f and V for which V was last proved to decrease
};

}  // namespace s2nnds
