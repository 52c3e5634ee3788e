// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/joint_loss.h"

#include <torch/autograd.h>

#include <numeric>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::tensor_list;

// A scalar whose gradients in three parameters are known already.
class Differentiated : public torch::autograd::Function<Differentiated> {
 public:
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& f, const torch::Tensor&,
                               const torch::Tensor&, double value, const tensor_list& gradients) {
    context->save_for_backward(gradients);
    return torch::scalar_tensor(value, f.options().requires_grad(false));
  }
  static tensor_list backward(AutogradContext* context, tensor_list adjoint) {
    tensor_list all = context->get_saved_variables();
    for (torch::Tensor& gradient : all) gradient = gradient * adjoint[0];
    all.resize(5);  // no gradients in the value and the list
    return all;
  }
};

template <typename Network>
NetworkShape shape_of(const Network& module) {
  const NetworkWeights weights = module->snapshot();
  return {module->network->shapes(), weights.head, weights.quadratic};
}

template <typename T>
std::unique_ptr<FusedLoss<T>> fused_loss(const Modules& m, const LossTable& table, const LossOptions& options,
                                         const Trains& trains) {
  return std::make_unique<FusedLoss<T>>(shape_of(m.f), shape_of(m.V), shape_of(m.B), table, options, trains);
}

}  // namespace

Engine engine_from(std::string_view name) {
  if (name == "fused") return Engine::fused;
  if (name == "autograd") return Engine::autograd;
  fail("engine: found \"{}\", expected fused or autograd", name);
}

JointLoss::JointLoss(const Modules& networks, const LossTable& table, const LossOptions& options,
                     Engine engine, const Trains& trains)
    : networks_(networks), table_(table), options_(options), trains_(trains) {
  if (engine == Engine::autograd) return;
  if (networks.f->network->theta.dtype() == torch::kFloat64) {
    double_loss_ = fused_loss<double>(networks, table, options, trains);
  } else {
    float_loss_ = fused_loss<float>(networks, table, options, trains);
  }
}

LossValue JointLoss::operator()(const BatchTensors& batch) {
  if (float_loss_) return run(*float_loss_, batch);
  if (double_loss_) return run(*double_loss_, batch);
  return autograd_loss(networks_, table_, options_, batch, trains_);
}

template <typename T>
LossValue JointLoss::run(FusedLoss<T>& loss, const BatchTensors& batch) {
  const torch::Tensor f = networks_.f->network->theta, V = networks_.V->network->theta,
                      B = networks_.B->network->theta;
  std::vector<torch::Tensor> kept;  // contiguous copies, where there had to be any
  const auto view = [&](const torch::Tensor& x) -> PointsView<T> {
    if (!x.defined()) return {};
    check(x.dim() == 2 && x.size(1) == networks_.f->network->inputs() && x.dtype() == f.dtype(),
          "joint loss: expected points [N, {}] of the networks' type", networks_.f->network->inputs());
    kept.push_back(x.contiguous());
    return {kept.back().data_ptr<T>(), x.size(0)};
  };
  const auto views = transform<PointsView<T>>(batch, view);
  check(views.position.count == views.velocity.count, "joint loss: found {} positions and {} velocities",
        views.position.count, views.velocity.count);
  check(views.boundary.count == views.normal.count, "joint loss: found {} boundary points and {} normals",
        views.boundary.count, views.normal.count);
  const tensor_list gradients = {torch::empty_like(f), torch::empty_like(V), torch::empty_like(B)};
  const PerTerm<double> terms =
      loss.run(f.data_ptr<T>(), V.data_ptr<T>(), B.data_ptr<T>(), views, gradients[0].data_ptr<T>(),
               gradients[1].data_ptr<T>(), gradients[2].data_ptr<T>());
  const double total = std::accumulate(terms.begin(), terms.end(), 0.0);
  return {terms, Differentiated::apply(f, V, B, total, gradients)};
}

}  // namespace s2nnds
