// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/training/counterexample.h"

namespace s2nnds {

// Options of both searches below.
struct FalsifierOptions {
  // Uniform samples in X, >= 1; a tenth as many each in X0, Xu and the workspace margin. LocalSearchFalsifier
  // takes a tenth of all of these.
  std::int64_t samples = 200000;
  std::int64_t keep = counterexamples_kept;  // worst violators of each condition that are handed on, >= 0
  ExecutionDemand execution = {};            // what the conditions ask for beyond the ideal motion
};

// Algorithm 2's search: fresh uniform samples of every region.
class RandomFalsifier : public CounterexampleSource {
 public:
  // Copies what it needs of the problem.
  RandomFalsifier(const SafetyProblem& problem, const FalsifierOptions& options);
  bool samples_uniformly() const override { return true; }
  Counterexamples find(const Networks& networks, const SafetyProblem& problem, double level_band,
                       std::uint64_t seed, std::int64_t round) override;

 private:
  FalsifierOptions options_;
  std::vector<RegionSampler> samplers_;  // of X0, Xu and the workspace margin, where there are any
};

// Starts from the points nearest to violating each condition and climbs the residual by random steps of
// shrinking length: finds violations on sets too small for uniform samples.
class LocalSearchFalsifier : public CounterexampleSource {
 public:
  // For each condition: `starts` points, each of which tries `steps` random steps. A step is normal with a
  // standard deviation that begins at 0.02 of the workspace's largest half width and falls by 0.75 a step.
  LocalSearchFalsifier(const SafetyProblem& problem, const FalsifierOptions& options, int starts = 200,
                       int steps = 20);
  Counterexamples find(const Networks& networks, const SafetyProblem& problem, double level_band,
                       std::uint64_t seed, std::int64_t round) override;

 private:
  FalsifierOptions options_;
  std::vector<RegionSampler> samplers_;
  int starts_;
  int steps_;
};

// What concerns B alone, in each of X0, Xu and the workspace margin: many uniform points, from the worst of which it
// climbs. In many dimensions violations are left in places, such as corners, that few points of a search of all
// conditions hit.
class RegionFalsifier : public CounterexampleSource {
 public:
  // `samples` points of each region, >= 1; `near_initial` and `near_unsafe` as for climb(), of X0 and of the others.
  RegionFalsifier(const SafetyProblem& problem, std::int64_t samples, double near_initial,
                  double near_unsafe);
  Counterexamples find(const Networks& networks, const SafetyProblem& problem, double level_band,
                       std::uint64_t seed, std::int64_t round) override;

 private:
  std::vector<std::pair<Condition, RegionSampler>> regions_;
  std::int64_t samples_;
  double near_initial_, near_unsafe_;
};

}  // namespace s2nnds
