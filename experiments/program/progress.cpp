// SPDX-License-Identifier: BSD-3-Clause
#include "progress.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>

#include "s2nnds/core/stopwatch.h"

namespace s2nnds::program {
namespace {

constexpr double kProofPause = 5.0;  // seconds between two lines about a proof

std::string counterexamples(const RoundSummary& row) {
  std::string text;
  for (std::size_t q = 0; q < all_conditions.size(); ++q) {
    if (row.counts[q] == 0) continue;
    text += fmt::format("{}{}={}", text.empty() ? "" : " ", to_string(all_conditions[q]), row.counts[q]);
  }
  if (text.empty()) text = "none";
  const bool kept = row.is_kept();
  if (row.islands > 0)
    text += fmt::format("; {{B > 0}} has {} island{}", row.islands, row.islands > 1 ? "s" : "");
  if (row.equilibria > 0)
    text += fmt::format("; f stands still at {} place{}", row.equilibria, row.equilibria > 1 ? "s" : "");
  if (row.is_impossible()) text += ": no certificate can exist so";
  if (row.clean() && !row.follows())
    text += fmt::format("; {:.2f} times as far from the demonstrations as allowed", row.deviation);
  if (row.stage == Stage::imitation_finetune)
    text += kept ? " (f fine-tuned)" : " (f, V and B stay as they were)";
  if (row.stage == Stage::enlarge)
    text += fmt::format(" ({}{{B <= 0}} is {:.1f} % of the workspace)",
                        kept ? "" : "undone: ", 100.0 * row.volume);
  return text;
}

}  // namespace

void print_round(const RoundSummary& row) {
  static const bool terminal = ::isatty(::fileno(stderr)) == 1;
  if (row.round == 0) {
    spdlog::info("warm start: mse={:.4g} seconds={:.1f}", row.mse, row.seconds);
    if (terminal)
      spdlog::info("{:>5} {:>8} {:>8} {:>7} {:>7}  counterexamples", "round", "loss", "mse", "pool",
                   "seconds");
  } else if (terminal) {
    spdlog::info("{:>5} {:>8.4f} {:>8.5f} {:>7} {:>7.1f}  {}", row.round, row.loss, row.mse, row.pool,
                 row.seconds, counterexamples(row));
  } else {
    spdlog::info("round={} loss={:.4f} mse={:.5f} pool={} seconds={:.1f} counterexamples: {}", row.round,
                 row.loss, row.mse, row.pool, row.seconds, counterexamples(row));
  }
}

void print_reading(const std::string& what, double share) { spdlog::info("{}: {:.0f} %", what, 100 * share); }

ProofProgress proof_printer() {
  return [watch = Stopwatch()](Condition condition, const BranchProgress& state) mutable {
    if (watch.seconds() < kProofPause) return;
    watch = Stopwatch();
    spdlog::info("proof of {}: boxes={} waiting={} refuted={} depth={} seconds={:.1f}", to_string(condition),
                 state.boxes, state.waiting, state.refuted, state.depth, state.seconds);
  };
}

}  // namespace s2nnds::program
