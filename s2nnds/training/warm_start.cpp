// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/warm_start.h"

#include <cmath>
#include <numbers>
#include <optional>

#include "s2nnds/core/random.h"
#include "s2nnds/networks/evaluator.h"
#include "s2nnds/training/flat_adam.h"
#include "s2nnds/training/loss_table.h"

namespace s2nnds {
namespace {

// A start has stalled with an MSE above this share of the mean squared velocity.
constexpr double kStalled = 0.25;
constexpr std::int64_t kBatch = 32;  // demonstration samples a step

double full_mse(const VectorField& f, const torch::Tensor& position, const torch::Tensor& velocity) {
  const auto rows = [](const torch::Tensor& x) -> Points {
    using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const Rows>(x.data_ptr<float>(), x.size(0), x.size(1)).cast<double>();
  };
  const Points error = BasicEvaluator<float>(f->snapshot()).value(rows(position)) - rows(velocity);
  return error.rowwise().squaredNorm().mean();
}

LossOptions unweighted() {
  LossOptions options;
  options.weight.fill(1.0);
  return options;
}

// The mean squared error of f, fused. V and B are as small as they can be, and unused.
class ImitationLoss {
 public:
  explicit ImitationLoss(const VectorField& f)
      : loss_({f->network->shapes(), f->snapshot().head}, unused(f), unused(f), imitation_table(),
              unweighted()),
        unused_(static_cast<std::size_t>(f->network->inputs()) + 1),
        unused_gradient_(unused_.size()) {}

  // Writes the gradient in f's parameters.
  void run(const float* theta, const PointsView<float>& position, const PointsView<float>& velocity,
           float* gradient) {
    BatchView<float> batch;
    batch.position = position;
    batch.velocity = velocity;
    loss_.run(theta, unused_.data(), unused_.data(), batch, gradient, unused_gradient_.data(),
              unused_gradient_.data());
  }

 private:
  static NetworkShape unused(const VectorField& f) { return {{{f->network->inputs(), 1}}}; }

  FusedLoss<float> loss_;
  std::vector<float> unused_, unused_gradient_;
};

void displace(const torch::Tensor& x, const torch::Tensor& rows, const Vector& jitter, RandomStream& random) {
  auto* value = x.data_ptr<float>();
  const auto* row = rows.data_ptr<std::int64_t>();
  for (std::int64_t i = 0; i < x.size(0); ++i) {
    if (jitter[row[i]] == 0.0) continue;
    for (std::int64_t k = 0; k < x.size(1); ++k)
      value[i * x.size(1) + k] += static_cast<float>(jitter[row[i]] * random.normal());
  }
}

void fit(VectorField& f, const torch::Tensor& position, const torch::Tensor& velocity, const Vector& jitter,
         const WarmStartOptions& options, Engine engine, RandomStream random) {
  torch::Tensor theta = f->network->theta, gradient = torch::empty_like(theta);
  std::optional<ImitationLoss> fused;
  if (engine == Engine::fused) fused.emplace(f);
  FlatAdam optimizer(options.weight_decay);
  torch::Tensor rows = torch::empty({kBatch}, torch::kInt64);
  const auto samples = static_cast<std::size_t>(position.size(0));
  for (std::int64_t step = 0; step < options.steps; ++step) {
    const double progress = static_cast<double>(step) / static_cast<double>(options.steps);
    const double rate = options.rate * 0.5 * (1.0 + std::cos(std::numbers::pi * progress));
    auto* row = rows.data_ptr<std::int64_t>();
    for (std::int64_t i = 0; i < kBatch; ++i) row[i] = static_cast<std::int64_t>(random.below(samples));
    const torch::Tensor x = position.index_select(0, rows), target = velocity.index_select(0, rows);
    displace(x, rows, jitter, random);
    if (fused) {
      fused->run(theta.data_ptr<float>(), {x.data_ptr<float>(), x.size(0)},
                 {target.data_ptr<float>(), target.size(0)}, gradient.data_ptr<float>());
    } else {
      theta.mutable_grad() = torch::Tensor();
      (f(x) - target).square().sum(1).mean().backward();
      gradient = theta.grad();
    }
    optimizer.step(rate, theta.numel(), gradient.data_ptr<float>(), theta.data_ptr<float>());
  }
}

}  // namespace

WarmStartSummary warm_start(VectorField& f, const torch::Tensor& position, const torch::Tensor& velocity,
                            const Vector& jitter, const WarmStartOptions& options, Engine engine,
                            std::uint64_t seed, const std::function<VectorField(std::int64_t)>& make) {
  const double motion = velocity.square().sum(1).mean().item<double>();
  WarmStartSummary best{.mse = std::numeric_limits<double>::infinity(), .stalled = true};
  for (std::int64_t attempt = 1; attempt <= options.attempts && best.stalled; ++attempt) {
    VectorField candidate = make(attempt);
    fit(candidate, position, velocity, jitter, options, engine,
        RandomStream(seed, "warm start/batches", attempt));
    const double mse = full_mse(candidate, position, velocity);
    const bool stalled = !(mse <= kStalled * motion);
    if (mse < best.mse || attempt == 1) {
      best = {mse, attempt, stalled};
      f = candidate;
    }
  }
  return best;
}

}  // namespace s2nnds
