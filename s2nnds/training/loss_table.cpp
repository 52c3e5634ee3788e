// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/loss_table.h"

#include "s2nnds/training/loss_barrier_decrease.h"
#include "s2nnds/training/loss_barrier_sets.h"
#include "s2nnds/training/loss_imitation.h"
#include "s2nnds/training/loss_lyapunov.h"
#include "s2nnds/training/loss_obstacle_normal.h"
#include "s2nnds/training/loss_rollout_safety.h"

namespace s2nnds {

LossTable loss_table(const LossOptions& options) {
  const bool paper = options.kind == "paper";
  using enum LossTerm;
  return {
      loss_part<ImitationPenalty>(imitation, Samples::demonstrations),
      paper ? loss_part<PaperLyapunovPenalty>(lyapunov, Samples::workspace)
            : loss_part<LyapunovPenalty>(lyapunov, Samples::workspace),
      loss_part<InitialPenalty>(barrier_sets, Samples::initial),
      loss_part<UnsafePenalty>(barrier_sets, Samples::unsafe),
      paper ? loss_part<PaperBarrierDecreasePenalty>(barrier_decrease, Samples::workspace)
            : loss_part<BarrierDecreasePenalty>(barrier_decrease, Samples::workspace),
      loss_part<SafeRolloutPenalty>(rollout_safety, Samples::safe),
      loss_part<UnsafeRolloutPenalty>(rollout_safety, Samples::unsafe_rollouts),
      loss_part<ObstacleNormalPenalty>(obstacle_normal, Samples::boundary),
  };
}

LossTable imitation_table() {
  return {loss_part<ImitationPenalty>(LossTerm::imitation, Samples::demonstrations)};
}

}  // namespace s2nnds
