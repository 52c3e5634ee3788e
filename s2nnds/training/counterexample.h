// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "s2nnds/conditions/condition.h"
#include "s2nnds/core/random.h"

namespace s2nnds {

// A source hands on at most this many violators of one condition, the worst ones: more would push out of the
// pools what earlier rounds found.
inline constexpr std::int64_t counterexamples_kept = 500;

// Points that violate a condition, worst first, perhaps followed by such that nearly do; and how many violations were seen
// in all.
struct Counterexamples {
  std::array<Points, condition_count> points;           // [k, n] each, for all_conditions[i]
  std::array<std::int64_t, condition_count> counts{};   // violations found (points may hold fewer, or more)
  std::array<std::int64_t, condition_count> samples{};  // points examined where the condition applied

  std::int64_t total() const;  // the sum of `counts`
};

// Something that looks for points where the networks violate a condition: random sampling, local search, or
// the open boxes of a proof. The trainer asks each source after every round, in the order in which they were
// added.
class CounterexampleSource {
 public:
  virtual ~CounterexampleSource() = default;
  // The violators of every condition. `level_band` is eps_B; `round` names the random streams of `seed`, so
  // that a resumed run sees what an unbroken one would.
  virtual Counterexamples find(const Networks& networks, const SafetyProblem& problem, double level_band,
                               std::uint64_t seed, std::int64_t round) = 0;
  // Asked only when all sources before it found nothing in a round that could be the last (a proof costs more
  // than samples).
  virtual bool only_when_clean() const { return false; }
  // Its samples are uniform in each region: where it finds nothing, what others find lies on small sets.
  virtual bool samples_uniformly() const { return false; }
};

}  // namespace s2nnds
