#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/core/options.h"
#include "s2nnds/training/loss_term.h"

namespace s2nnds {

// The first fit of f to the demonstrations alone (METHOD: warm start).
struct WarmStartOptions {
  std::int64_t steps = 12000;  // Adam steps, cosine decay of the rate to 0
  std::int64_t batch = 512;    // demonstration samples a step
  double rate = 2e-3;
  double weight_decay = 0.1;  // decoupled (AdamW), of all weights of f
  double clip = 1.0;          // norm of the gradient
  std::int64_t attempts = 4;  // a start that stalls is drawn anew this often
  double stalled = 0.25;      // stalled: MSE above this share of the mean squared velocity

  void visit(FieldVisitor& v);
};

// The losses of the joint training: the weighted sum of the terms of loss_term.h, whose formulas are in a file
// each, loss_<term>.h. `paper` takes those of the paper's (7) and (8) as printed where they differ.
struct LossOptions {
  std::string kind = "robust";
  PerTerm<double> weight = {{
      10.0,  // imitation
      5.0,   // lyapunov
      2.0,   // barrier_sets
      5.0,   // barrier_decrease
      1.0,   // rollout_safety
      // obstacle_normal. Motions that would meet the obstacle turn aside before it, which leaves more of the
      // workspace safe. Not all can: V falls along every motion, so followed backwards those that end at the
      // obstacle come from the workspace's edge. The gap through which they come gets narrower, and the
      // certificate harder to find.
      0.1,
  }};
  double decay_rate = 0.1;
  double margin_initial = 0.05;
  double margin_unsafe = 0.05;
  double margin_barrier_decrease = 0.05;
  double band_width = 0.15;
  double margin_positive = 0.01;  // paper: delta_l1
  double margin_decrease = 0.0;   // paper: delta_l2, as printed: its sign favours Vdot < delta_l2
  double leak = 0.0;              // of the leaky ReLU; 0: relu. The paper's alpha

  void visit(FieldVisitor& v);
};

// Where a step's samples come from.
struct BatchOptions {
  std::int64_t demonstrations = 512;
  // Standard deviation (normalised units) of a normal displacement of those in X0: in the warm start in all
  // directions, then across the velocity only. Motions start slowly, so what error of f turns them aside
  // there hardly shows in the MSE.
  double start_jitter = 0.02;
  std::int64_t workspace = 512;
  std::int64_t initial = 128;
  std::int64_t unsafe = 256;
  std::int64_t workspace_margin = 256;
  std::int64_t labels = 256;      // half of them with safe rollouts
  std::int64_t upstream = 128;    // beside them, of the repairs
  std::int64_t corrections = 64;  // beside the demonstrations, of the repairs
  std::int64_t boundary = 128;    // of the obstacle, where there is a obstacle_normal
  // Shares of the workspace batch; the rest is uniform in X.
  double share_counterexamples = 0.3;
  double share_band = 0.25;  // points with |B| < band_near
  double share_goal = 0.15;  // log-uniform distance to the goal
  double band_near = 0.06;
  std::int64_t band_refresh = 100;  // steps after which the points near {B = 0} are sought anew

  void visit(FieldVisitor& v);
};

struct TrainerOptions {
  std::string engine = "fused";  // fused, autograd (the reference)
  std::int64_t rounds = 40;      // at most
  std::int64_t min_rounds = 5;   // stopping at the first clean round underfits the demonstrations
  std::int64_t steps = 500;      // Adam steps a round
  double rate_f = 1e-3;
  double rate_certificates = 5e-3;  // V and B
  double rate_decay = 0.9;          // a round
  double rate_floor = 0.05;         // least factor of the rates
  double rate_end = 0.05;  // within a round the rates fall to this share (cosine): what noise of the steps
                           // leaves behind looks like violations that no training removes
  std::int64_t rate_rise = 50;  // steps of a round over which the rates rise from 0
  std::int64_t rate_period =
      10;  // rounds after which the decay starts anew: small rates do not leave a bad shape
  bool redraw_barrier = true;  // B starts anew with the rates: no training mends some shapes
  // Factors of the demonstrations' weight and of the labels' and the obstacle_normal's, once more each time the
  // rates start anew: what could not be certified must give way somewhere. Where motions fan out before the
  // obstacle, those that meet it come through a gap so narrow that labels which fill it leave no room for B
  // to fall. The motion that is certified then may pass the obstacle on the other side than the
  // demonstrations.
  double restart_mse = 0.5;
  double restart_rollout_safety = 0.3;
  // A round after one in which random search found fewer counterexamples than this mends: its rates are
  // lower, and the labels, which press {B = 0} against the motions where Bdot < 0 is hard to meet, and the
  // obstacle_normal weigh less with every such round. So many rounds may mend in a row, then one follows at full
  // rates.
  std::int64_t refine_rounds = 4;
  std::int64_t refine_below = 200;
  double refine_rate = 0.33;   // factor of all rates
  double refine_labels = 0.6;  // factor of these two weights, once more with each refining round
  double refine_band = 3.0;    // factor of the band's weight
  // So many motions at most that enter {B > 0} at a counterexample are followed back before each round until
  // the first clean one. Where one comes from X0, f is fitted to the velocity of the nearest demonstration
  // sample plus backtrack_gain times the way to it; where it does not, B is trained to be positive along it. The
  // losses at the counterexample itself can make do with an f that is nearly still there.
  std::int64_t backtrack_motions = 64;
  double backtrack_gain = 0.5;  // 1 / normalised time
  // After every round B is shifted by at most this to the level that gives the largest safe set without a
  // violation among some samples, if there is one.
  double max_level_shift = 0.1;
  // Rounds after the first clean one that train all three with more weight on the demonstrations, so that f
  // comes nearer to what it would be without conditions; what such a round makes of them is kept only if it
  // is clean as well.
  std::int64_t imitation_finetune_rounds = 6;
  double imitation_finetune_mse =
      10.0;  // factor of the demonstrations' weight; less after such a round failed
  double imitation_finetune_rate = 0.3;  // factor of all rates
  // Rounds after these that train B alone, with f and V as they are and the labels weighing
  // more, so that the safe set grows; what such a round makes of B is kept only if it is clean as well.
  std::int64_t enlarge_rounds = 10;
  double enlarge_labels = 4.0;   // factor of the labels' weight, at most; less after such a round failed
  double enlarge_margins = 2.0;  // factor of the barrier_sets's and the band's weights
  double enlarge_rate = 0.5;     // factor of B's rate
  double clip = 1.0;             // norm of each network's gradient
  double weight_decay = 0.2;     // decoupled (AdamW), of all weights of f
  std::int64_t rollout_points = 6000;  // relabelled every round by rollouts; 0: no labels
  double smoothing = 1.0;  // share of a phase regression's velocities in those that f is fitted to
  double tube = 0.0;       // width of its samples beside the demonstrations, normalised units; 0: none
  // Demonstration samples nearer to Xu than this (per axis) leave the MSE term; twice this for demonstrations
  // that pass through Xu, whose samples within Xu by more than this stay.
  double obstacle_margin = 0.05;
  std::int64_t samples = 200000;       // random search for counterexamples after each round
  std::int64_t pool_additions = 500;   // violators of one condition that join the pool each round
  std::int64_t pool_capacity = 20000;  // the oldest counterexamples leave beyond this
  double level_band = 0.01;            // eps_B: Bdot < 0 must hold where |B| <= level_band
  WarmStartOptions warm_start;
  LossOptions loss;
  BatchOptions batch;

  void visit(FieldVisitor& v);
};

// The paper's algorithm: losses (6) to (8), Algorithm 2 with uniform samples and counterexamples only.
TrainerOptions paper_training();

// f alone: only the imitation term counts, for the rounds that a certificate takes at least.
TrainerOptions imitation_training();

}  // namespace s2nnds
