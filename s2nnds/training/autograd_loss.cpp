// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/autograd_loss.h"

#include <torch/autograd.h>

#include <limits>

namespace s2nnds {
namespace {

// [N, n] over its norms; 0 where they are.
torch::Tensor unit(const torch::Tensor& vectors) {
  const torch::Tensor size = vectors.norm(2, {1}, true);
  return torch::where(size == 0.0, torch::zeros_like(vectors), vectors / size);
}

// As worst_perturbation.h for gradients [N, n] and f(x) [N, n]; constants. `jacobian` [N, n, n] may be
// undefined.
torch::Tensor worst_perturbations(const ExecutionModel& model, const torch::Tensor& gradient,
                                  const torch::Tensor& f, const torch::Tensor& jacobian) {
  const torch::Tensor command = f.norm(2, {1}, true) + model.field_error,
                      relative = model.velocity_error_relative * command + model.field_error;
  torch::Tensor delta = (model.velocity_error / model.least_speed + relative) * unit(gradient);
  if (!jacobian.defined()) return delta;
  const double window = model.window() + model.lag;
  const torch::Tensor pulled = torch::einsum("bij,bi->bj", {jacobian, gradient}),
                      along = (pulled * f).sum(1, true),
                      error = model.position_error +
                              window * (model.velocity_error + model.most_speed * relative);
  const torch::Tensor displacement = error * unit(pulled) + window * model.most_speed * along.sign() * f;
  return delta + torch::einsum("bij,bj->bi", {jacobian, displacement});
}

// d f_i / d x_j [N, n, n], constants; undefined where the model does not need it.
torch::Tensor jacobian_of(VectorField& f, const torch::Tensor& x, const ExecutionModel& model) {
  if (!model.displaces()) return {};
  const torch::Tensor point = x.detach().requires_grad_(true), value = f(point);
  std::vector<torch::Tensor> rows;
  for (std::int64_t i = 0; i < x.size(1); ++i)
    rows.push_back(torch::autograd::grad({value.select(1, i).sum()}, {point}, {}, true, false)[0]);
  return torch::stack(rows, 1).detach();
}

// A scalar network W and grad W . direction, both [N]; the direction may be undefined. `perturb` gives what
// is added to it where grad W is known.
template <typename Network, typename Perturb>
void evaluate(Network& network, const torch::Tensor& x, const torch::Tensor& direction,
              const Perturb& perturb, torch::Tensor& value, torch::Tensor& dot) {
  const torch::Tensor point = x.detach().requires_grad_(direction.defined());
  value = network(point);
  if (!direction.defined()) return;
  const torch::Tensor gradient = torch::autograd::grad({value.sum()}, {point}, {}, true, true)[0];
  const torch::Tensor delta = perturb(gradient.detach());
  dot = (gradient * (delta.defined() ? direction + delta : direction)).sum(1);
}

// What the projection of LossOptions::projection adds to f [N, n] at x; a constant.
torch::Tensor projection_of(Lyapunov& V, const torch::Tensor& x, const torch::Tensor& f, double decay) {
  const torch::Tensor point = x.detach().requires_grad_(true), value = V(point);
  const torch::Tensor gradient = torch::autograd::grad({value.sum()}, {point})[0],
                      excess = torch::relu((gradient * f.detach()).sum(1) + decay * value.detach()),
                      square = gradient.square().sum(1).clamp_min(std::numeric_limits<float>::min());
  return -(excess / square).unsqueeze(1) * gradient;
}

SampleTensors with_constants(SampleTensors at, const Quantities& constant) {
  if (constant.f) at.f = at.f.detach();
  if (constant.V) at.V = at.V.detach();
  if (constant.V_dot) at.V_dot = at.V_dot.detach();
  if (constant.B) at.B = at.B.detach();
  if (constant.B_dot) at.B_dot = at.B_dot.detach();
  return at;
}

}  // namespace

SampleTensors quantities_at(Modules& networks, const BatchTensors& batch, Samples set,
                            const Quantities& needs, const LossOptions& options) {
  const ExecutionDemand& demand = options.execution;
  const torch::Tensor& x = batch.points(set);
  SampleTensors at;
  at.beside = batch.beside(set);
  if (needs.any_f()) at.f = networks.f(x);
  const torch::Tensor none;
  const bool of_V = needs.V_dot && demand.asks_of_lyapunov(), of_B = needs.B_dot && demand.asks_of_barrier();
  const torch::Tensor jacobian = of_V || of_B ? jacobian_of(networks.f, x, demand.model) : none;
  const auto perturb_V = [&](const torch::Tensor& gradient) {
    if (!of_V) return none;
    const torch::Tensor beyond = x.norm(2, {1}, true) > demand.convergence_radius;
    return torch::where(beyond, worst_perturbations(demand.model, gradient, at.f.detach(), jacobian),
                        torch::zeros_like(gradient));
  };
  const auto perturb_B = [&](const torch::Tensor& gradient) {
    if (options.projection > 0.0) return projection_of(networks.V, x, at.f, options.projection);
    return of_B ? worst_perturbations(demand.model, gradient, at.f.detach(), jacobian) : none;
  };
  if (needs.any_V()) evaluate(networks.V, x, needs.V_dot ? at.f : none, perturb_V, at.V, at.V_dot);
  if (needs.any_B()) evaluate(networks.B, x, needs.B_dot ? at.f : none, perturb_B, at.B, at.B_dot);
  return at;
}

LossValue autograd_loss(Modules& networks, const LossTable& table, const LossOptions& options,
                        const BatchTensors& batch, const Trains& trains) {
  LossValue loss{.terms = {}, .total = torch::zeros({}, networks.f->network->theta.options())};
  for (const Samples set : all_samples) {
    const torch::Tensor& x = batch.points(set);
    if (!x.defined() || x.size(0) == 0) continue;
    const auto counts = [&](const LossPart& part) {
      return part.samples == set && applies(part, options, trains);
    };
    Quantities needs;
    for (const LossPart& part : table) {
      if (counts(part)) needs = needs | part.needs;
    }
    const SampleTensors at = quantities_at(networks, batch, set, needs, options);
    for (const LossPart& part : table) {
      if (!counts(part)) continue;
      const torch::Tensor value =
          options.weight[part.term] * part.values(options, with_constants(at, part.constant)).mean();
      loss.terms[part.term] += value.item<double>();
      loss.total = loss.total + value;
    }
  }
  return loss;
}

}  // namespace s2nnds
