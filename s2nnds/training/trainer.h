// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "s2nnds/networks/dynamics.h"
#include "s2nnds/networks/network_options.h"
#include "s2nnds/problem/start_paths.h"
#include "s2nnds/training/batch_sampler.h"
#include "s2nnds/training/counterexample.h"
#include "s2nnds/training/history.h"
#include "s2nnds/training/trainer_options.h"

namespace s2nnds {

// All that training needs to go on as if it had never stopped. It holds no random numbers: their streams are
// named by round.
struct TrainerState {
  Networks networks;                  // f, V and B after the last round
  CounterexamplePools pools;          // the counterexamples found so far
  std::vector<RoundSummary> history;  // history[k].round == k
};

// How a training ended.
struct TrainerSummary {
  // Whether the networks are those of a round that ended without counterexamples from any source.
  bool clean = false;
  bool stopped = false;               // a callback asked to stop
  std::int64_t rounds = 0;            // rounds of joint training, those before a resumption included
  std::int64_t left_out_samples = 0;  // demonstration samples too near to the obstacle
  double seconds = 0.0;               // of training, as RoundSummary::seconds
};

// Labels starts [N, n] by their rollouts: true where safe and reaching the goal.
using RolloutLabels = std::function<std::vector<bool>(const Dynamics& dynamics, const Points& starts)>;

// What the motions that leave the demonstrations' way, from these or from X0, should be corrected to;
// drawn anew for each round.
using MotionCorrections = std::function<VelocityTargets(const Dynamics& dynamics, std::int64_t round)>;

// What is looked at after a round besides counterexamples: fills in deviation (where the round was clean),
// islands and equilibria.
using RoundLook = std::function<void(const Networks& networks, RoundSummary& row)>;

// The counterexample-guided loop (the paper's Algorithm 2): warm start of f, then rounds of joint training of
// f, V and B as plan.h says, each followed by a search for counterexamples.
class Trainer {
 public:
  // `demonstrations` are the training demonstrations, normalised. The problem must outlive the trainer.
  Trainer(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
          const NetworkOptions& networks, const TrainerOptions& options, std::uint64_t seed);
  ~Trainer();
  Trainer(Trainer&&) noexcept;  // afterwards the other one may only be destroyed

  // Asks this source too after every round, in the order of the calls; without a source every round is clean.
  void add_source(std::shared_ptr<CounterexampleSource> source);
  // Sets what labels TrainerOptions::rollout_points.
  void set_rollout_labels(RolloutLabels labels);
  // Sets what corrects motions before each round that trains f.
  void set_corrections(MotionCorrections corrections);
  // Sets what looks at the motion's fidelity and topology.
  void set_look(RoundLook look);
  // Called after the warm start (round 0) and after every round; return false to stop.
  void on_round(std::function<bool(const RoundSummary&, const Trainer&)> callback);

  TrainerSummary run();                     // trains from the current state to the end of the schedule
  TrainerState state() const;               // as of the last round, for a checkpoint
  void restore(const TrainerState& state);  // throws Error if the networks do not fit
  Networks networks() const;                // f, V and B as they are now

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace s2nnds
