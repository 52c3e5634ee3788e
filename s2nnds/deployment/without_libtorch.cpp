// SPDX-License-Identifier: BSD-3-Clause
// What takes the place of the files that need LibTorch where it is not linked. Loading it takes most of a second,
// which is much for a program that only reads a run.

#include "s2nnds/core/check.h"
#include "s2nnds/deployment/torchscript.h"
#include "s2nnds/runs/libtorch.h"
#include "s2nnds/runs/training_run.h"

namespace s2nnds {

bool has_libtorch() { return false; }

void set_tensor_threads(int) {}

std::optional<int> tensor_threads() { return std::nullopt; }

TrainerSummary train(const PreparedRun&, RunRecord&, const TrainingHooks&) {
  fail("training: found a program without LibTorch, expected one that is linked to it");
}

std::string torchscript_module(const Policy&) {
  fail("TorchScript: found a program without LibTorch, expected one that is linked to it");
}

}  // namespace s2nnds
