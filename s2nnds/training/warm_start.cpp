#include "s2nnds/training/warm_start.h"

#include <cmath>
#include <numbers>
#include <optional>

#include "s2nnds/core/random.h"
#include "s2nnds/training/flat_adam.h"
#include "s2nnds/training/fused_loss.h"
#include "s2nnds/training/losses.h"

namespace s2nnds {
namespace {

double full_mse(VectorField& f, const torch::Tensor& position, const torch::Tensor& velocity) {
  torch::NoGradGuard no_grad;
  return imitation_loss(f(position), velocity).item<double>();
}

// The fused loss with nothing but the imitation term: V and B are as small as they can be, and unused.
class ImitationSweep {
 public:
  explicit ImitationSweep(const VectorField& f)
      : sweep_({f->network->shapes(), f->snapshot().head}, unused(f), unused(f), only_imitation()),
        unused_(static_cast<std::size_t>(f->network->inputs()) + 1),
        unused_gradient_(unused_.size()) {}

  // Writes the gradient of the mean squared error in f's parameters.
  void run(const float* theta, const PointsView<float>& position, const PointsView<float>& velocity,
           float* gradient) {
    BatchView<float> batch;
    batch.position = position;
    batch.velocity = velocity;
    sweep_.run(theta, unused_.data(), unused_.data(), batch, gradient, unused_gradient_.data(),
               unused_gradient_.data());
  }

 private:
  static NetworkShape unused(const VectorField& f) { return {{{f->network->inputs(), 1}}}; }
  static LossOptions only_imitation() {
    LossOptions options;
    options.weight = {};
    options.weight[LossTerm::imitation] = 1.0;
    return options;
  }

  FusedLoss<float> sweep_;
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
         const WarmStartOptions& options, RandomStream random) {
  torch::Tensor theta = f->network->theta, gradient = torch::empty_like(theta);
  std::optional<ImitationSweep> sweep;
  if (f->network->engine == Engine::fused) sweep.emplace(f);
  FlatAdam optimizer(options.weight_decay, options.clip);
  torch::Tensor rows = torch::empty({options.batch}, torch::kInt64);
  const auto samples = static_cast<std::size_t>(position.size(0));
  for (std::int64_t step = 0; step < options.steps; ++step) {
    const double progress = static_cast<double>(step) / static_cast<double>(options.steps);
    const double rate = options.rate * 0.5 * (1.0 + std::cos(std::numbers::pi * progress));
    auto* row = rows.data_ptr<std::int64_t>();
    for (std::int64_t i = 0; i < options.batch; ++i)
      row[i] = static_cast<std::int64_t>(random.below(samples));
    const torch::Tensor x = position.index_select(0, rows), target = velocity.index_select(0, rows);
    displace(x, rows, jitter, random);
    if (sweep) {
      sweep->run(theta.data_ptr<float>(), {x.data_ptr<float>(), x.size(0)},
                 {target.data_ptr<float>(), target.size(0)}, gradient.data_ptr<float>());
    } else {
      theta.mutable_grad() = torch::Tensor();
      imitation_loss(f(x), target).backward();
      gradient = theta.grad();
    }
    optimizer.step(rate, theta.numel(), gradient.data_ptr<float>(), theta.data_ptr<float>());
  }
}

}  // namespace

WarmStartSummary warm_start(VectorField& f, const torch::Tensor& position, const torch::Tensor& velocity,
                            const Vector& jitter, const WarmStartOptions& options, std::uint64_t seed,
                            const std::function<VectorField(std::int64_t)>& make) {
  const double motion = velocity.square().sum(1).mean().item<double>();
  WarmStartSummary best{.mse = std::numeric_limits<double>::infinity(), .stalled = true};
  for (std::int64_t attempt = 1; attempt <= options.attempts && best.stalled; ++attempt) {
    VectorField candidate = make(attempt);
    fit(candidate, position, velocity, jitter, options, RandomStream(seed, "warm start/batches", attempt));
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
