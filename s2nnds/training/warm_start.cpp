#include "s2nnds/training/warm_start.h"

#include <cmath>
#include <numbers>

#include "s2nnds/core/random.h"
#include "s2nnds/training/flat_adam.h"
#include "s2nnds/training/losses.h"

namespace s2nnds {
namespace {

double full_mse(VectorField& f, const torch::Tensor& position, const torch::Tensor& velocity) {
  torch::NoGradGuard no_grad;
  return imitation_loss(f(position), velocity).item<double>();
}

void fit(VectorField& f, const torch::Tensor& position, const torch::Tensor& velocity,
         const WarmStartOptions& options, RandomStream random) {
  torch::Tensor theta = f->network->theta;
  FlatAdam optimizer(options.weight_decay, options.clip);
  torch::Tensor rows = torch::empty({options.batch}, torch::kInt64);
  const auto samples = static_cast<std::size_t>(position.size(0));
  for (std::int64_t step = 0; step < options.steps; ++step) {
    const double progress = static_cast<double>(step) / static_cast<double>(options.steps);
    const double rate = options.rate * 0.5 * (1.0 + std::cos(std::numbers::pi * progress));
    auto* row = rows.data_ptr<std::int64_t>();
    for (std::int64_t i = 0; i < options.batch; ++i)
      row[i] = static_cast<std::int64_t>(random.below(samples));
    theta.mutable_grad() = torch::Tensor();
    imitation_loss(f(position.index_select(0, rows)), velocity.index_select(0, rows)).backward();
    optimizer.step(rate, theta.numel(), theta.grad().data_ptr<float>(), theta.data_ptr<float>());
  }
}

}  // namespace

WarmStartSummary warm_start(VectorField& f, const torch::Tensor& position, const torch::Tensor& velocity,
                            const WarmStartOptions& options, std::uint64_t seed,
                            const std::function<VectorField(std::int64_t)>& make) {
  const double motion = velocity.square().sum(1).mean().item<double>();
  WarmStartSummary best{.mse = std::numeric_limits<double>::infinity(), .stalled = true};
  for (std::int64_t attempt = 1; attempt <= options.attempts && best.stalled; ++attempt) {
    VectorField candidate = make(attempt);
    fit(candidate, position, velocity, options, RandomStream(seed, "warm start/batches", attempt));
    const double mse = full_mse(candidate, position, velocity);
    const bool stalled = !(mse <= options.stalled * motion);
    if (mse < best.mse || attempt == 1) {
      best = {mse, attempt, stalled};
      f = candidate;
    }
  }
  return best;
}

}  // namespace s2nnds
