// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/training_run.h"

#include <cmath>

#include "s2nnds/runs/disturbance_falsifier.h"
#include "s2nnds/runs/proof_source.h"
#include "s2nnds/runs/training_checkpoint.h"
#include "s2nnds/training/falsifier.h"

namespace s2nnds {

TrainerSummary train(const PreparedRun& setup, RunRecord& record, const TrainingHooks& hooks) {
  const Config& config = setup.config;
  Trainer trainer(setup.problem, setup.train(), config.networks, config.training, config.seed);
  const FalsifierOptions search{config.training.samples};
  trainer.add_source(std::make_shared<RandomFalsifier>(setup.problem, search));
  trainer.add_source(std::make_shared<LocalSearchFalsifier>(setup.problem, search));
  if (config.verification.method == Method::proof) {
    ProofOptions quick = ProofOptions::fail_fast();
    if (setup.problem.dimension() > 2)
      quick.max_boxes = quick.max_after_refuted = config.verification.proof.max_boxes;
    trainer.add_source(std::make_shared<ProofSource>(quick));
    trainer.add_source(std::make_shared<DisturbanceFalsifier>());
  }
  trainer.set_rollout_labels([&](const NetworkWeights& f, const Points& starts) {
    return rollout_is_safe(f, setup.problem, starts);
  });
  if (record.checkpoint) trainer.restore(to_trainer_state(record));
  trainer.on_round([&](const RoundSummary& row, const Trainer& current) {
    store_trainer_state(current.state(), record);
    // All rounds after it keep what was clean. Where the prover is a source, everything is proved from here on.
    if (row.clean() && row.stage == Stage::search && row.round >= config.training.min_rounds)
      record.timing.first_clean_round = row.seconds;
    if (hooks.progress) hooks.progress(row);
    if (hooks.checkpoint) hooks.checkpoint(record);
    return std::isfinite(row.loss);
  });
  const TrainerSummary summary = trainer.run();
  record.checkpoint->finished = true;
  record.timing.training = summary.seconds;
  record.certificate = {};
  record.certificate.weight_hash = weight_hash(record.networks);
  record.certificate.level_band = config.training.level_band;
  return summary;
}

}  // namespace s2nnds
