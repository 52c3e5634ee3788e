// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>

#include "s2nnds/core/points.h"
#include "s2nnds/networks/vector_field.h"
#include "s2nnds/training/joint_loss.h"

namespace s2nnds {

// How a warm start ended.
struct WarmStartSummary {
  double mse = 0.0;  // mean of |f(x) - xdot|^2 over all samples, normalised units, after the last step
  std::int64_t attempt = 1;  // the start that was kept, from 1
  bool stalled = false;      // every attempt stalled; the best was kept
};

// Fits f to (position, velocity) [N, n] alone, each position displaced by its own standard deviation `jitter`
// [N] whenever it is drawn: AdamW on the MSE with cosine decay. A start that stalls, so that f hardly moves
// with the demonstrations, is drawn anew with `make`(attempt); the best one is returned in `f`.
WarmStartSummary warm_start(VectorField& f, const torch::Tensor& position, const torch::Tensor& velocity,
                            const Vector& jitter, const WarmStartOptions& options, Engine engine,
                            std::uint64_t seed, const std::function<VectorField(std::int64_t attempt)>& make);

}  // namespace s2nnds
