#include "progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>

namespace s2nnds::program {
namespace {

constexpr std::chrono::seconds kProofPause(5);  // between two lines about a proof

std::string counterexamples(const RoundSummary& row) {
  std::string text;
  for (std::size_t q = 0; q < all_conditions.size(); ++q) {
    if (row.counts[q] == 0) continue;
    text += fmt::format("{}{}={}", text.empty() ? "" : " ", to_string(all_conditions[q]), row.counts[q]);
  }
  if (text.empty()) text = "none";
  const bool kept = row.counterexamples() == 0;
  if (row.stage == Stage::imitation_finetune)
    text += kept ? " (f fine-tuned)" : " (f, V and B stay as they were)";
  if (row.stage == Stage::enlarge) text += kept ? " (B grew)" : " (B stays as it was)";
  return text;
}

std::string figure(double value, const char* unit = "") {
  return std::isnan(value) ? std::string("not measured") : fmt::format("{:.4g}{}", value, unit);
}

}  // namespace

void print_round(const RoundSummary& row) {
  static const bool terminal = ::isatty(::fileno(stderr)) == 1;
  if (row.round == 0) {
    fmt::print(stderr, "warm start: mse={:.4g} seconds={:.1f}\n", row.mse, row.seconds);
    if (terminal)
      fmt::print(stderr, "{:>5} {:>8} {:>8} {:>7} {:>7}  counterexamples\n", "round", "loss", "mse", "pool",
                 "seconds");
  } else if (terminal) {
    fmt::print(stderr, "{:>5} {:>8.4f} {:>8.5f} {:>7} {:>7.1f}  {}\n", row.round, row.loss, row.mse, row.pool,
               row.seconds, counterexamples(row));
  } else {
    fmt::print(stderr, "round={} loss={:.4f} mse={:.5f} pool={} seconds={:.1f} counterexamples: {}\n",
               row.round, row.loss, row.mse, row.pool, row.seconds, counterexamples(row));
  }
  std::fflush(stderr);
}

ProofProgress proof_printer() {
  using Clock = std::chrono::steady_clock;
  return [said = Clock::now()](Condition condition, const BranchProgress& state) mutable {
    if (Clock::now() - said < kProofPause) return;
    said = Clock::now();
    fmt::print(stderr, "proof of {}: boxes={} waiting={} refuted={} depth={} seconds={:.1f}\n",
               to_string(condition), state.boxes, state.waiting, state.refuted, state.depth, state.seconds);
    std::fflush(stderr);
  };
}

void print_summary(const RunRecord& record, const std::string& path) {
  const Certificate& certificate = record.certificate;
  fmt::print("{} (seed {}): guarantee {}\n", record.name, record.seed, certificate.guarantee);
  if (!certificate.statement.empty()) fmt::print("  {}\n", certificate.statement);
  for (const ConditionVerdict& v : certificate.conditions) {
    if (v.method == "proof") {
      fmt::print("  {:<20} {:<10} {:<9} boxes {} open {} (volume {:.3g})\n", v.condition, v.method, v.verdict,
                 v.boxes, v.open_boxes, v.open_volume);
      continue;
    }
    fmt::print("  {:<20} {:<10} {:<9} samples {} violations {} worst {:.3g}", v.condition, v.method,
               v.verdict, v.samples, v.violations, v.worst);
    if (v.method == "conformal") {
      fmt::print(" p {:.3g} (l = {}, eps = {:.3g}, beta = {:.3g}, tightest eps {:.3g})", v.quantile, v.order,
                 v.epsilon, v.beta, v.tightest_epsilon);
    }
    fmt::print("\n");
  }
  const EvaluationSummary& e = record.evaluation;
  fmt::print("  mse train {} test {}, sd test {}, dtw train {} test {} (normalised units)\n",
             figure(e.mse_train), figure(e.mse_test), figure(e.sd_test), figure(e.dtw_train),
             figure(e.dtw_test));
  fmt::print("  safe area {} of {} that is truly safe (ratio {})\n", figure(e.safe_area),
             figure(e.true_safe_area), figure(e.safe_area_ratio));
  for (const auto& [name, seconds] : flatten(record.timing)) {
    if (seconds != "nan") fmt::print("  {} {} s", name, seconds);
  }
  fmt::print("\n  run {}\n", path);
}

}  // namespace s2nnds::program
