// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <torch/types.h>

#include <memory>
#include <string_view>

#include "s2nnds/training/autograd_loss.h"
#include "s2nnds/training/fused_loss.h"

namespace s2nnds {

// How a loss and its gradients are computed. Both give the same numbers up to rounding.
enum class Engine {
  fused,     // FusedLoss: fast
  autograd,  // torch operations and double backward: the reference
};
Engine engine_from(std::string_view name);  // "fused", "autograd"; throws Error on another name

// The loss of three networks, again and again. The networks keep their identity: their weights may change
// between calls, the modules may not.
class JointLoss {
 public:
  // Keeps the modules, and copies the table and the options. The fused engine takes its shapes from the
  // modules.
  JointLoss(const Modules& networks, const LossTable& table, const LossOptions& options, Engine engine,
            const Trains& trains = {});

  // The loss of one batch. Throws Error if the shapes or types of its tensors do not fit.
  LossValue operator()(const BatchTensors& batch);

 private:
  template <typename T>
  LossValue run(FusedLoss<T>& loss, const BatchTensors& batch);

  Modules networks_;
  LossTable table_;
  LossOptions options_;
  Trains trains_;
  std::unique_ptr<FusedLoss<float>> float_loss_;
  std::unique_ptr<FusedLoss<double>> double_loss_;
};

}  // namespace s2nnds
