// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <torch/torch.h>

#include <cstdint>

#include "s2nnds/conditions/condition.h"
#include "s2nnds/training/flat_adam.h"
#include "s2nnds/training/joint_loss.h"
#include "s2nnds/training/loss_table.h"

// The work that all benchmarks share: the paper's networks and batches, as the peer's script has them, scaled
// in width and dimension.
namespace s2nnds::benchmarks {

struct WorkSize {
  std::int64_t dimension = 2;
  std::int64_t width_f = 64;              // 4 hidden layers
  std::int64_t width_certificates = 128;  // 3 hidden layers each
  std::int64_t samples = 512;  // demonstration and workspace samples each; an eighth initial and unsafe each
};

NetworkOptions network_options(const WorkSize& size);

// One joint step: loss, gradients, three Adam updates.
class TrainingStep {
 public:
  explicit TrainingStep(const WorkSize& size);
  ~TrainingStep();
  void run();            // on fresh workspace samples
  double flops() const;  // useful ones of a run

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// The residuals of all conditions at uniform points of the workspace.
class Scoring {
 public:
  Scoring(const WorkSize& size, std::int64_t points);
  void run();
  double flops() const;

 private:
  Networks networks_;
  SafetyProblem problem_;
  Points points_;
};

// The workspace [-1, 1]^n, a box of starts, a ball in the way.
SafetyProblem make_sets(std::int64_t dimension);

// Useful flops are multiply-adds of dense layers times two; activations, biases, losses and optimisers are
// not counted. A layer [out, in] on one sample costs 2 out in for each of: the value; the tangent; the
// adjoint of its input, unless nothing asks for it (the first layer's, where the input is a sample); the
// adjoint of its input's tangent; the weight gradient from the value; the weight gradient from the tangent.
struct Multiplications {
  double all = 0.0;    // out in, summed over layers
  double inner = 0.0;  // without the first layer
  explicit Multiplications(const NetworkWeights& stack);
  double value() const { return 2.0 * all; }
  double value_and_tangent() const { return 4.0 * all; }
  double training_on_value() const { return 2.0 * (2.0 * all + inner); }
  double training_on_both() const { return 2.0 * (5.0 * all + inner); }
};

}  // namespace s2nnds::benchmarks
