#pragma once

#include <torch/torch.h>

#include <memory>

#include "s2nnds/training/fused_loss.h"
#include "s2nnds/training/losses.h"

namespace s2nnds {

// The loss of LossOptions of three networks, again and again: joint_loss of losses.h where the networks'
// engine is autograd, one FusedLoss where it is fused. The networks keep their identity: their weights may
// change between calls, the modules may not.
class JointLoss {
 public:
  // With Trains::barrier, the gradients of f and V are left out where that saves time.
  JointLoss(const Modules& networks, const LossOptions& options, Trains trains = Trains::all);

  // total is differentiable in the networks' parameters. Throws Error if tensors do not fit.
  LossValue operator()(const BatchTensors& batch);

 private:
  template <typename T>
  LossValue run(FusedLoss<T>& sweep, const BatchTensors& batch);

  Modules networks_;
  LossOptions options_;
  std::unique_ptr<FusedLoss<float>> float_sweep_;
  std::unique_ptr<FusedLoss<double>> double_sweep_;
};

}  // namespace s2nnds
