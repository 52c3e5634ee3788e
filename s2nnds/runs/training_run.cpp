// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/training_run.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/evaluation/topology.h"
#include "s2nnds/runs/execution_falsifier.h"
#include "s2nnds/runs/motion_report.h"
#include "s2nnds/runs/proof_source.h"
#include "s2nnds/runs/training_checkpoint.h"
#include "s2nnds/training/band_falsifier.h"
#include "s2nnds/training/falsifier.h"
#include "s2nnds/training/orientation_fit.h"

namespace s2nnds {
namespace {

// In space the band |B| <= eps_B holds few of uniform samples, and moving so many points onto it costs a tenth of the
// proof that would find the same violations.
constexpr std::int64_t kBandSamples = 3000;

// Limits of the proofs within training. What succeeds takes a tenth of the boxes; what does not would go on to
// any limit, and a few hundred points of violations are all that a round can use.
ProofOptions quick_proof(const Config& config, std::int64_t dimension) {
  ProofOptions quick = ProofOptions::fail_fast();
  if (dimension > 2) {
    quick.max_boxes = config.verification.proof.max_boxes;
    quick.max_after_refuted *= 10;
  }
  return quick;
}

}  // namespace

TrainerSummary train(const PreparedRun& setup, RunRecord& record, const TrainingHooks& hooks) {
  const Config& config = setup.config;
  TrainerOptions options = config.training;
  options.loss.execution = execution_demand(config.execution, setup.data.frame);
  options.loss.execution.model.velocity_error += config.execution.speed * options.margin;
  Trainer trainer(setup.problem, setup.train(), config.networks, options, config.seed);
  // The prover sees all that samples can miss.
  const bool proves = config.verification.method == Method::proof;
  const FalsifierOptions search{
      .samples = std::max<std::int64_t>(1, config.training.samples / (proves ? 10 : 1)),
      .execution = options.loss.execution};
  trainer.add_source(std::make_shared<RandomFalsifier>(setup.problem, search));
  // What leaves less than half of a margin is trained on as if it were a violation.
  const double half_decrease = 0.5 * options.loss.margin_barrier_decrease;
  if (proves) {
    if (setup.problem.dimension() > 2)
      trainer.add_source(std::make_shared<BandFalsifier>(kBandSamples, half_decrease));
    trainer.add_source(std::make_shared<ProofSource>(quick_proof(config, setup.problem.dimension())));
    const ExecutionModel& model = options.loss.execution.model;
    if (!model.is_ideal()) trainer.add_source(std::make_shared<ExecutionFalsifier>(model));
  } else {
    trainer.add_source(std::make_shared<LocalSearchFalsifier>(setup.problem, search));
    if (setup.problem.dimension() > most_proved_dimensions) {
      // The rate on the band is the roughest of the residuals.
      const LossOptions& loss = options.loss;
      const std::int64_t samples = std::max<std::int64_t>(1, config.training.samples / 10);
      trainer.add_source(std::make_shared<RegionFalsifier>(setup.problem, samples, 0.5 * loss.margin_initial,
                                                           0.5 * loss.margin_unsafe));
      trainer.add_source(std::make_shared<BandFalsifier>(3 * samples, half_decrease));
    }
  }
  trainer.set_rollout_labels(
      [&](const Dynamics& f, const Points& starts) { return rollout_is_safe(f, setup.problem, starts); });
  trainer.set_look([&](const Networks& networks, RoundSummary& row) {
    // The last stage leaves f as it is.
    if (row.clean() && row.stage != Stage::enlarge)
      row.deviation = worst_deviation(setup, networks.dynamics(), row.round);
    if (row.stage != Stage::search || row.clean()) return;
    const Topology topology = find_topology(networks.dynamics(), networks.B, setup.problem);
    row.islands = std::ssize(topology.islands);
    row.equilibria = std::ssize(topology.equilibria);
  });
  if (config.training.start_paths > 0.0) {
    trainer.set_corrections(
        [&](const Dynamics& f, std::int64_t round) { return corrections_of(setup, f, round); });
  }
  if (record.checkpoint) trainer.restore(to_trainer_state(record));
  trainer.on_round([&](const RoundSummary& row, const Trainer& current) {
    store_trainer_state(current.state(), record);
    // All rounds after it keep what was clean. Where the prover is a source, everything is proved from here
    // on.
    const bool certified =
        row.is_kept() && row.stage == Stage::search && row.round >= config.training.min_rounds;
    if (certified) record.timing.first_clean_round = row.seconds;
    if (hooks.progress) hooks.progress(row);
    if (hooks.checkpoint) hooks.checkpoint(record);
    if (hooks.cancelled && hooks.cancelled()) return false;
    return std::isfinite(row.loss) && !(certified && hooks.until_certified);
  });
  const TrainerSummary summary = trainer.run();
  record.checkpoint->finished = !(summary.stopped && hooks.until_certified);
  if (setup.data.frame.has_orientation()) {
    record.orientation =
        fit_orientation(setup.train(), setup.data.frame, record.networks.B, setup.problem.workspace,
                        config.orientation, static_cast<std::uint64_t>(config.seed));
  }
  record.timing.training = summary.seconds;
  record.certificate = {};
  record.pushes = {};
  record.certificate.weight_hash = weight_hash(record.networks);
  record.certificate.level_band = config.training.level_band;
  return summary;
}

}  // namespace s2nnds
