// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/band_falsifier.h"

#include <algorithm>

#include "s2nnds/verification/band_sampler.h"

namespace s2nnds {

Counterexamples BandFalsifier::find(const Networks& networks, const SafetyProblem& problem, double level_band,
                                    std::uint64_t seed, std::int64_t round) {
  RandomStream random(seed, "falsifier/band", round);
  const Points x = BandSampler(networks.B, problem.workspace, level_band).sample(samples_, random);
  Counterexamples found;
  const auto q = static_cast<std::size_t>(Condition::barrier_decrease);
  found.samples[q] = x.rows();
  found.points[q].resize(0, problem.dimension());
  if (x.rows() == 0) return found;
  const Vector rate = residual(Condition::barrier_decrease, networks, problem, level_band, x);
  std::vector<Eigen::Index> violators;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    if (is_violated(Condition::barrier_decrease, rate[i])) violators.push_back(i);
  }
  found.counts[q] = std::ssize(violators);
  violators.resize(std::min<std::size_t>(violators.size(), counterexamples_kept));
  found.points[q] = x(violators, Eigen::all);
  return found;
}

}  // namespace s2nnds
