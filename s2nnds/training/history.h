// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <numeric>

#include "s2nnds/conditions/condition.h"
#include "s2nnds/training/loss_term.h"

namespace s2nnds {

// What a round is for. The stages after `search` keep only rounds without counterexamples.
enum class Stage : std::uint8_t {
  search,              // a certificate
  imitation_finetune,  // an f nearer to the demonstrations
  // A larger safe set; B alone trains.
  enlarge
};

// One row of the history: a round of joint training and the search for counterexamples after it.
struct RoundSummary {
  std::int64_t round = 0;        // from 1; 0 is the warm start
  double loss = 0.0;             // mean over the round's steps, as the next two
  PerTerm<double> loss_terms{};  // with their weights: they add up to the loss
  double mse = 0.0;              // of f on the demonstrations; the last round's where f does not train
  std::array<std::int64_t, condition_count> counts{};  // counterexamples found, by condition
  std::int64_t found_by_sampling = 0;                  // of these, by sources that sample uniformly
  std::int64_t pool = 0;                               // counterexamples kept for training
  double safe_share = 0.0;                             // of the label points, those with safe rollouts
  double volume = 0.0;  // of {B <= 0} as a share of X, by sampling, after rounds that let it grow
  // How far the motions are from the demonstrations, as a share of what is allowed, and what no certificate can
  // have (evaluation/topology.h). Looked for where there is a RoundLook, deviation after clean rounds only.
  double deviation = 0.0;
  std::int64_t islands = 0;     // parts of {B > 0} that do not reach the edge
  std::int64_t equilibria = 0;  // of f, other than the goal
  Stage stage = Stage::search;  // what the round was for
  double seconds = 0.0;         // of training since its start, interruptions left out

  // The sum of `counts`.
  std::int64_t counterexamples() const {
    return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  }
  // Whether it was a round of joint training after which no source found a counterexample.
  bool clean() const { return round > 0 && counterexamples() == 0; }
  bool follows() const { return deviation <= 1.0; }                     // NaN does not
  bool is_kept() const { return clean() && follows(); }                 // what later stages keep
  bool is_impossible() const { return islands > 0 || equilibria > 0; }  // as a certificate's topology
};

}  // namespace s2nnds
