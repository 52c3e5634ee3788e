// SPDX-License-Identifier: BSD-3-Clause
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

// Points of a batch that no option counts: about as many as of Xu, so that no term starves.
inline constexpr Eigen::Index labelled_points = 256;  // by rollouts, half of them safe
inline constexpr Eigen::Index upstream_points = 128;  // of motions followed back into {B > 0}
inline constexpr Eigen::Index correction_points =
    64;  // of motions followed back to X0, beside the demonstrations
inline constexpr Eigen::Index boundary_points_drawn = 128;  // of the obstacle's boundary

// Draws training batches. What it knows of the networks (points near {B = 0}, rollout labels, motions
// followed back) is handed to it.
class BatchSampler {
 public:
  // Demonstration samples too near to the unsafe set (options.obstacle_margin) are left out. Points of the
  // obstacle's boundary are drawn only where the term obstacle_normal has a weight. Throws Error where no
  // sample is left, or the shares of the batch add up to more than 1.
  BatchSampler(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
               const TrainerOptions& options);

  Batch draw(RandomStream& random) const;
  Points uniform(std::int64_t count, RandomStream& random) const;  // in X: [count, n]

  void add(const Counterexamples& found);
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
