#pragma once

#include <optional>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/problem/boundary_points.h"
#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/training/backtrack.h"
#include "s2nnds/training/batch.h"
#include "s2nnds/training/counterexample.h"
#include "s2nnds/training/trainer_options.h"

namespace s2nnds {

using Batch = BatchOf<Points>;

// Counterexamples found so far: what a checkpoint keeps besides the networks.
struct CounterexamplePools {
  Points workspace, initial, unsafe;  // [k, n], oldest first
};

// Draws training batches. What it knows of the networks (points near {B = 0}, rollout labels, repairs) is
// handed to it.
class BatchSampler {
 public:
  // `obstacle_margin`: demonstration samples nearer to the unsafe set than this, per axis, are left out; twice as
  // near for demonstrations that pass through it, unless they lie within it by that much.
  BatchSampler(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
               const BatchOptions& options, double obstacle_margin);

  Batch draw(RandomStream& random) const;
  Points uniform(std::int64_t count, RandomStream& random) const;  // in X: [count, n]

  void add(const Counterexamples& found, std::int64_t additions, std::int64_t capacity);
  void set_near_band(Points points) { near_band_ = std::move(points); }
  void set_labels(Points safe, Points unsafe_rollouts);
  void set_backtracked(Backtracked backtracked) { backtracked_ = std::move(backtracked); }

  const CounterexamplePools& pools() const { return pools_; }
  void set_pools(CounterexamplePools pools) { pools_ = std::move(pools); }
  const Points& position() const { return position_; }  // demonstration samples that were kept
  const Points& velocity() const { return velocity_; }
  const Vector& jitter() const { return jitter_; }  // standard deviation of each sample's displacement
  std::int64_t left_out_samples() const { return left_out_; }

 private:
  Points draw_workspace(RandomStream& random) const;

  const SafetyProblem& problem_;
  BatchOptions options_;
  Points position_, velocity_;
  Vector jitter_;
  std::int64_t left_out_ = 0;
  std::optional<RegionSampler> initial_, unsafe_, workspace_margin_;
  CounterexamplePools pools_;
  Points near_band_, safe_, unsafe_rollouts_;
  Backtracked backtracked_;
  BoundaryPoints boundary_;
};

}  // namespace s2nnds
