// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/conditions/execution_model.h"
#include "s2nnds/core/options.h"
#include "s2nnds/training/loss_term.h"

namespace s2nnds {

// The first fit of f to the demonstrations alone.
struct WarmStartOptions {
  std::int64_t steps = 12000;  // Adam steps of 32 samples, >= 1, over which the rate falls to 0 (cosine)
  double rate = 3e-3;          // Adam's rate at first, > 0
  double weight_decay = 0.05;  // decoupled (AdamW), of all weights of f, >= 0
  std::int64_t attempts = 4;   // starts of f at most, >= 1: one that stalls is drawn anew

  void visit(FieldVisitor& v);  // names every key and its range
};

// The losses of the joint training: the weighted sum of the terms of loss_term.h, whose formulas are in a
// file each, loss_<term>.h. `paper` takes those of the paper's (7) and (8) as printed where they differ.
struct LossOptions {
  std::string kind = "robust";  // robust, paper: the profile says which
  // Factor of each term, >= 0; 0 leaves it out.
  PerTerm<double> weight = {{
      10.0,  // imitation
      5.0,   // lyapunov
      2.0,   // barrier_sets
      5.0,   // barrier_decrease
      1.0,   // rollout_safety; in five and more dimensions 0.3 of it counts
      // obstacle_normal. Motions that would meet the obstacle turn aside before it, which leaves more of the
      // workspace safe. Not all can: V falls along every motion, so followed backwards those that end at the
      // obstacle come from the workspace's edge. The gap through which they come gets narrower, and the
      // certificate harder to find.
      0.1,
  }};
  double decay_rate = 0.1;       // robust: 1 / normalised time, >= 0; Vdot <= -decay_rate V is wanted on X
  double margin_initial = 0.05;  // in B, >= 0: B <= -margin_initial is wanted on X0
  double margin_unsafe = 0.05;   // in B, >= 0: B >= margin_unsafe is wanted on Xu and the workspace margin
  // In B per normalised time, >= 0. robust: Bdot <= -margin_barrier_decrease is wanted around {B = 0}. paper:
  // Bdot <= margin_barrier_decrease on X, as printed.
  double margin_barrier_decrease = 0.05;
  double band_width = 0.15;       // robust: in B, > 0; barrier_decrease counts by exp(-(B / band_width)^2)
  double margin_positive = 0.01;  // paper: delta_l1, in V, >= 0; V >= margin_positive is wanted on X
  // paper: delta_l2, in V per normalised time, any sign. As printed: Vdot <= margin_decrease is wanted on X.
  double margin_decrease = 0.0;
  double leak = 0.0;  // paper: alpha, the slope of the leaky ReLU below 0, in [0, 1]; 0: relu
  // No key: follows from [execution]. Vdot and Bdot are those of the worst motion that it admits.
  ExecutionDemand execution = {};
  // No key: follows from networks.f. kappa of a projected f, >= 0; 0: it is not. Bdot is along the projected
  // velocity, whose difference from f(x) counts as constant; all else is of f itself, so that little is left to
  // the projection.
  double projection = 0.0;

  void visit(FieldVisitor& v);  // names every key and its range
};

// How many samples a step draws, and where. The shares may add up to 1 at most.
struct BatchOptions {
  std::int64_t demonstrations = 256;  // samples of the demonstrations a step, >= 1
  // Standard deviation (normalised units, >= 0) of a normal displacement of those in X0: in the warm start in
  // all directions, then across the velocity only. Motions start slowly, so what error of f turns them aside
  // there hardly shows in the imitation loss.
  double start_jitter = 0.02;
  std::int64_t workspace = 256;  // samples of X a step, >= 1
  std::int64_t initial = 64;     // samples of X0 a step, >= 1
  // Samples of the demonstrations a step, >= 0, at which B is wanted as on X0: motions that start in X0 and follow them
  // stay in {B <= 0}, whatever f is by then. None where a demonstration meets Xu: motions turn aside there.
  std::int64_t path = 64;
  std::int64_t unsafe = 128;  // samples of Xu a step, >= 1, and as many of the workspace margin
  // Of the samples of X, in [0, 1]: counterexamples, with a little jitter.
  double share_counterexamples = 0.3;
  double share_band = 0.25;  // of the samples of X, in [0, 1]: where B is nearly 0
  double share_goal = 0.15;  // of the samples of X, in [0, 1]: at log-uniform distances to the goal

  void visit(FieldVisitor& v);  // names every key and its range
};

// What is fit for the plane costs too much in more dimensions than this, or misses what matters.
inline constexpr std::int64_t few_dimensions = 4;

// Options of the joint training. The schedule of rounds that they make is in plan.h.
struct TrainerOptions {
  std::string engine = "fused";     // what computes losses and gradients: fused, autograd (the reference)
  std::int64_t rounds = 40;         // rounds that search for a certificate, at most; >= 1
  std::int64_t min_rounds = 1;      // first that may end the search, >= 1
  std::int64_t steps = 300;         // Adam steps a round, >= 1; twice as many in five and more dimensions
  double rate_f = 1e-3;             // Adam's rate for f, > 0
  double rate_certificates = 5e-3;  // Adam's rate for V and B, > 0
  double rate_decay = 0.9;          // factor of the rates from round to round, in (0, 1]
  // Rounds after which the search starts anew from the warm start's f: low rates do not change a bad shape,
  // and some shapes no training changes. >= 0; 0: never.
  std::int64_t rate_period = 10;
  // First rounds of the search that train B alone, >= 0: for networks that come from a like scene.
  std::int64_t barrier_rounds = 0;
  bool relax_weights = true;  // with every new start imitation, rollout_safety, obstacle_normal weigh less
  bool refine = true;         // a round after one that was nearly clean trains carefully
  // Motions that violate a condition are followed back and corrected; not where f is projected
  bool backtrack = true;
  double max_level_shift = 0.1;  // of B after a round, to a better level without violations, >= 0; 0: none
  std::int64_t imitation_finetune_rounds = 10;  // rounds after a clean one that fit f more closely, >= 0
  std::int64_t enlarge_rounds = 10;  // rounds after these that train B alone, for a larger safe set, >= 0
  std::int64_t enlarge_steps = 300;  // Adam steps of such a round, >= 1
  double weight_decay = 0.2;         // decoupled (AdamW), of all weights of f, >= 0
  // Points of X labelled by rollouts, anew every round, >= 0; 0: none. A quarter of them in five and more dimensions.
  std::int64_t rollout_points = 4000;
  double smoothing = 1.0;  // share, in [0, 1], of a phase regression in the velocities that f is fitted to
  // Samples, as a share of the demonstrations' (>= 0; 0: none), of motions from 32 starts in X0 that differ
  // from those shown: displaced demonstrations, whose displacement falls along the way.
  double start_paths = 0.02;
  // Samples, as a share of the demonstrations' (>= 0; 0: none), of places beside the demonstrations, where f leads back
  // to them.
  double funnel = 0.3;
  // Where demonstrations pass through Xu, f is shown a way around it, besides, that keeps so far from it (normalised
  // units, per axis, >= 0; 0: none). Not in five and more dimensions.
  double detour = 0.06;
  // Demonstration samples nearer to Xu than this (normalised units, per axis, >= 0) are left out; twice this
  // for demonstrations that pass through Xu, whose samples within Xu by more than this stay. In five and more
  // dimensions, where a box of this size meets most obstacles, a thirtieth of it counts.
  double obstacle_margin = 0.03;
  // Points of X in the random search for counterexamples after each round, >= 1; a tenth of them where the
  // prover looks, too.
  std::int64_t samples = 200000;
  double level_band = 0.01;  // eps_B > 0: Bdot < 0 must hold where |B| <= level_band
  // Normalised velocity, >= 0: {B <= 0} must withstand disturbances of this size, too; on top of what
  // [execution] asks.
  double margin = 0.0;
  WarmStartOptions warm_start;  // the first fit of f alone
  LossOptions loss;             // the terms of the loss
  BatchOptions batch;           // the samples of a step

  void visit(FieldVisitor& v);  // names every key and its range
};

// The paper's algorithm: losses (6) to (8), Algorithm 2 with uniform samples and counterexamples only.
TrainerOptions paper_training();

// f alone: only the imitation term counts, for the rounds that a certificate takes at least.
TrainerOptions imitation_training();

}  // namespace s2nnds
