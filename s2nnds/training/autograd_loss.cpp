// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/autograd_loss.h"

#include <torch/autograd.h>

namespace s2nnds {
namespace {

// A scalar network W and grad W . direction, both [N]; the direction may be undefined.
template <typename Network>
void evaluate(Network& network, const torch::Tensor& x, const torch::Tensor& direction, torch::Tensor& value,
              torch::Tensor& dot) {
  const torch::Tensor point = x.detach().requires_grad_(direction.defined());
  value = network(point);
  if (!direction.defined()) return;
  const torch::Tensor gradient = torch::autograd::grad({value.sum()}, {point}, {}, true, true)[0];
  dot = (gradient * direction).sum(1);
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
                            const Quantities& needs) {
  const torch::Tensor& x = batch.points(set);
  SampleTensors at;
  at.beside = batch.beside(set);
  if (needs.any_f()) at.f = networks.f(x);
  const torch::Tensor none;
  if (needs.any_V()) evaluate(networks.V, x, needs.V_dot ? at.f : none, at.V, at.V_dot);
  if (needs.any_B()) evaluate(networks.B, x, needs.B_dot ? at.f : none, at.B, at.B_dot);
  return at;
}

LossValue autograd_loss(Modules& networks, const LossTable& table, const LossOptions& options,
                        const BatchTensors& batch, Trains trains) {
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
    const SampleTensors at = quantities_at(networks, batch, set, needs);
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
