// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/problem/boundary_points.h"
#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/problem/start_paths.h"
#include "s2nnds/training/backtrack.h"
#include "s2nnds/training/batch.h"
#include "s2nnds/training/counterexample.h"
#include "s2nnds/training/trainer_options.h"

namespace s2nnds {

// The points of one training step as they are drawn.
using Batch = BatchOf<Points>;

// Counterexamples found so far: what a checkpoint keeps besides the networks.
struct CounterexamplePools {
  Points workspace,  // [k, n], oldest first: where a condition on X was violated
      initial,       // the same on X0
      unsafe;        // the same on Xu and the workspace margin
};

// Points of a batch whose label comes from a rollout, half of them safe. This number and the next three are
// no options: they are near BatchOptions::unsafe, so that each term of the loss has enough points.
inline constexpr Eigen::Index labelled_points = 256;
inline constexpr Eigen::Index upstream_points = 128;  // points of motions followed back into {B > 0}
// Points of motions followed back to X0, and of those that stray. They come on top of
// BatchOptions::demonstrations.
inline constexpr Eigen::Index correction_points = 128;
inline constexpr Eigen::Index boundary_points_drawn = 128;  // points of the obstacle's boundary

// Draws training batches. What it knows of the networks (points near {B = 0}, rollout labels, motions
// followed back) is handed to it.
class BatchSampler {
 public:
  // f is fitted to the demonstrations and to what it is shown beside them (the funnel, ways around the unsafe set).
  // Samples of both too near to that set (options.obstacle_margin) are left out. Points of the obstacle's boundary are
  // drawn only where the term obstacle_normal has a weight. Throws Error where no sample of the demonstrations is left, or
  // the shares of the batch add up to more than 1.
  BatchSampler(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
               const TrainerOptions& options, const VelocityTargets& beside = {});

  Batch draw(RandomStream& random) const;                          // the points of one step
  Points uniform(std::int64_t count, RandomStream& random) const;  // uniform in X: [count, n]

  // Appends the points to the pools. A pool that is full forgets its oldest points.
  void add(const Counterexamples& found);
  // Points [k, n] near {B = 0}, of which BatchOptions::share_band draws.
  void set_near_band(Points points) { near_band_ = std::move(points); }
  // Points [k, n] whose rollouts are safe, and points whose rollouts are not.
  void set_labels(Points safe, Points unsafe_rollouts);
  // Whether samples beside the demonstrations are drawn, too; at first they are.
  void set_draws_beside(bool draws) { drawn_ = draws ? position_.rows() : shown_; }
  // What motions followed back ask for, until the next call.
  void set_backtracked(Backtracked backtracked) { backtracked_ = std::move(backtracked); }

  const CounterexamplePools& pools() const { return pools_; }               // for a checkpoint
  void set_pools(CounterexamplePools pools) { pools_ = std::move(pools); }  // of a checkpoint
  // [K, n]: demonstration samples that are kept, then those beside them
  const Points& position() const { return position_; }
  Eigen::Index shown_samples() const { return shown_; }  // of these, those of the demonstrations
  const Points& velocity() const { return velocity_; }   // [K, n]: the velocities there
  const Vector& jitter() const { return jitter_; }  // [K]: standard deviation of each sample's displacement
  // Demonstration samples that are left out: too near to the unsafe set.
  std::int64_t left_out_samples() const { return left_out_; }

 private:
  Points draw_workspace(RandomStream& random) const;

  const SafetyProblem& problem_;
  BatchOptions options_;
  Points position_, velocity_;
  Vector jitter_;
  Eigen::Index shown_ = 0, drawn_ = 0;  // rows: of demonstrations, and of all that is drawn
  std::int64_t left_out_ = 0;
  std::optional<RegionSampler> initial_, unsafe_, workspace_margin_;
  // Of the three, in many dimensions, where drawing from a thin set anew for each step would cost more than the step.
  Points initial_stock_, unsafe_stock_, margin_stock_;
  CounterexamplePools pools_;
  Points path_;  // [P, n]: what motions from X0 pass that are like the demonstrations
  Points near_band_, safe_, unsafe_rollouts_;
  Backtracked backtracked_;
  BoundaryPoints boundary_;
};

}  // namespace s2nnds
