// SPDX-License-Identifier: BSD-3-Clause
#include "work.h"

namespace s2nnds::benchmarks {
namespace {

torch::Tensor uniform(std::int64_t samples, std::int64_t dimension) {
  return torch::rand({samples, dimension}) * 2.0 - 1.0;
}

Modules make_modules(const WorkSize& size) {
  const NetworkOptions options = network_options(size);
  RandomStream random(0, "benchmark");
  return {VectorField(size.dimension, options.f, random), Lyapunov(size.dimension, options.V, random),
          Barrier(size.dimension, options.B, random)};
}

Networks snapshot(const Modules& modules) {
  return {modules.f->snapshot(), modules.V->snapshot(), modules.B->snapshot()};
}

}  // namespace

NetworkOptions network_options(const WorkSize& size) {
  NetworkOptions options = paper_networks();
  options.f.network.hidden.assign(4, size.width_f);
  options.V.network.hidden.assign(3, size.width_certificates);
  options.B.network.hidden.assign(3, size.width_certificates);
  return options;
}

Multiplications::Multiplications(const NetworkWeights& stack) {
  for (const Layer& layer : stack.layers) all += static_cast<double>(layer.weight.size());
  inner = all - static_cast<double>(stack.layers.front().weight.size());
}

class TrainingStep::Impl {
 public:
  explicit Impl(const WorkSize& size) : size_(size), modules_(make_modules(size)) {
    batch_.position = uniform(size.samples, size.dimension);
    batch_.velocity = uniform(size.samples, size.dimension);
    batch_.initial = torch::rand({size.samples / 8, size.dimension});
    batch_.unsafe = -torch::rand({size.samples / 8, size.dimension});
  }

  // The one place that knows how a loss is computed.
  torch::Tensor loss() { return loss_(batch_).total; }

  void run() {
    batch_.workspace = uniform(size_.samples, size_.dimension);
    const torch::Tensor total = loss();
    for (torch::Tensor& parameter : parameters_) parameter.mutable_grad() = torch::Tensor();
    total.backward();
    for (std::size_t k = 0; k < 3; ++k) {
      optimizers_[k].step(1e-3, parameters_[k].numel(), parameters_[k].grad().data_ptr<float>(),
                          parameters_[k].data_ptr<float>());
    }
  }

  double flops() const {
    const Networks networks = snapshot(modules_);
    const auto n = static_cast<double>(size_.samples);
    return 2.0 * n * Multiplications(networks.f).training_on_value() +
           n * Multiplications(networks.V).training_on_both() +
           n * Multiplications(networks.B).training_on_both() +
           n / 4.0 * Multiplications(networks.B).training_on_value();
  }

 private:
  WorkSize size_;
  Modules modules_;
  BatchTensors batch_;
  LossOptions options_{.kind = "paper", .leak = 0.01};
  JointLoss loss_{modules_, loss_table(options_), options_, Engine::fused};
  torch::Tensor parameters_[3] = {modules_.f->network->theta, modules_.V->network->theta,
                                  modules_.B->network->theta};
  FlatAdam optimizers_[3] = {FlatAdam(0.0), FlatAdam(0.0), FlatAdam(0.0)};
};

TrainingStep::TrainingStep(const WorkSize& size) : impl_(std::make_unique<Impl>(size)) {}
TrainingStep::~TrainingStep() = default;
void TrainingStep::run() { impl_->run(); }
double TrainingStep::flops() const { return impl_->flops(); }

SafetyProblem make_sets(std::int64_t dimension) {
  SafetyProblem problem;
  const Vector one = Vector::Ones(dimension);
  problem.workspace = Box{-one, one};
  Vector lower = -0.07 * one, upper = 0.07 * one, center = Vector::Zero(dimension);
  lower[0] = -1.0;
  upper[0] = -0.88;
  center[0] = -0.4;
  center[1] = 0.35;
  problem.initial = box_region(Box{lower, upper});
  problem.unsafe = ball(center, 0.1);
  return problem;
}

Scoring::Scoring(const WorkSize& size, std::int64_t points)
    : networks_(snapshot(make_modules(size))), problem_(make_sets(size.dimension)) {
  RandomStream random(0, "points");
  points_ = Points::NullaryExpr(points, size.dimension, [&] { return random.uniform(-1.0, 1.0); });
}

// In single precision, as the peer.
void Scoring::run() { residuals(networks_, problem_, 0.005, points_, Precision::single_); }

double Scoring::flops() const {
  return static_cast<double>(points_.rows()) *
         (Multiplications(networks_.f).value() + Multiplications(networks_.V).value_and_tangent() +
          Multiplications(networks_.B).value_and_tangent());
}

}  // namespace s2nnds::benchmarks
