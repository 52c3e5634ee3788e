#include "s2nnds/training/losses.h"

#include "s2nnds/conditions/lie_derivative.h"

namespace s2nnds {
namespace {

// What the loss is made of: the networks on the batch, f in one pass and B's values in one pass.
struct Outputs {
  torch::Tensor velocity;                                // f on the demonstrations
  LieDerivative V, B;                                    // on the workspace samples
  torch::Tensor initial, unsafe, safe, unsafe_rollouts;  // B there; undefined where there are none
  torch::Tensor leaving;  // n.f on the obstacle's boundary; undefined without one
};

Outputs evaluate(Modules& networks, const BatchTensors& batch) {
  Outputs out;
  const std::int64_t leaving = batch.boundary.defined() ? batch.boundary.size(0) : 0;
  std::vector<torch::Tensor> moving = {batch.position, batch.workspace};
  if (leaving > 0) moving.push_back(batch.boundary);
  const torch::Tensor moved = networks.f(torch::cat(moving));
  out.velocity = moved.narrow(0, 0, batch.position.size(0));
  const torch::Tensor direction = moved.narrow(0, batch.position.size(0), batch.workspace.size(0));
  if (leaving > 0) out.leaving = (moved.narrow(0, moved.size(0) - leaving, leaving) * batch.normal).sum(1);
  out.V = lie_derivative(networks.V, batch.workspace, direction);
  out.B = lie_derivative(networks.B, batch.workspace, direction);

  std::vector<torch::Tensor> points;
  std::vector<torch::Tensor*> results;
  const auto ask = [&](const torch::Tensor& x, torch::Tensor& result) {
    if (!x.defined() || x.size(0) == 0) return;
    points.push_back(x);
    results.push_back(&result);
  };
  ask(batch.initial, out.initial);
  ask(batch.unsafe, out.unsafe);
  ask(batch.safe, out.safe);
  ask(batch.unsafe_rollouts, out.unsafe_rollouts);
  if (points.empty()) return out;
  const torch::Tensor values = networks.B(torch::cat(points));
  std::int64_t at = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    *results[i] = values.narrow(0, at, points[i].size(0));
    at += points[i].size(0);
  }
  return out;
}

// The mean of `values`, or zero where there are none.
torch::Tensor mean_or_zero(const torch::Tensor& values, const torch::Tensor& like) {
  return values.defined() ? values.mean() : torch::zeros({}, like.options());
}
template <typename Penalty>
torch::Tensor mean_penalty(const torch::Tensor& values, const torch::Tensor& like, Penalty penalty) {
  return mean_or_zero(values.defined() ? penalty(values) : torch::Tensor(), like);
}

void robust_terms(const Outputs& out, const LossOptions& o, PerTerm<torch::Tensor>& terms) {
  const torch::Tensor& like = out.velocity;
  const torch::Tensor q = out.V.derivative / (out.V.value + 1e-6) + o.decay_rate;
  terms[LossTerm::lyapunov] = o.weight[LossTerm::lyapunov] * torch::log1p(torch::relu(q)).mean();
  const auto below = [&](double margin) {
    return [=](const torch::Tensor& b) { return torch::relu(b + margin); };
  };
  const auto above_zero = [&](double margin) {
    return [=](const torch::Tensor& b) { return torch::relu(margin - b); };
  };
  terms[LossTerm::barrier_sets] =
      o.weight[LossTerm::barrier_sets] * (mean_penalty(out.initial, like, below(o.margin_initial)) +
                                          mean_penalty(out.unsafe, like, above_zero(o.margin_unsafe)));
  const torch::Tensor weight = torch::exp(-(out.B.value.detach() / o.band_width).square());
  terms[LossTerm::barrier_decrease] =
      o.weight[LossTerm::barrier_decrease] *
      (weight * torch::relu(out.B.derivative + o.margin_barrier_decrease)).mean();
  terms[LossTerm::rollout_safety] =
      o.weight[LossTerm::rollout_safety] *
      (mean_penalty(out.safe, like, below(o.margin_rollout_safety)) +
       mean_penalty(out.unsafe_rollouts, like, above_zero(o.margin_rollout_safety)));
  terms[LossTerm::obstacle_normal] = o.weight[LossTerm::obstacle_normal] *
                                     mean_penalty(out.leaving, like, above_zero(o.margin_obstacle_normal));
}

void paper_terms(const Outputs& out, const LossOptions& o, PerTerm<torch::Tensor>& terms) {
  const torch::Tensor& like = out.velocity;
  const auto leaky = [&](const torch::Tensor& z) { return torch::leaky_relu(z, o.leak); };
  terms[LossTerm::lyapunov] =
      o.weight[LossTerm::lyapunov] *
      (leaky(o.margin_positive - out.V.value) + leaky(out.V.derivative - o.margin_decrease)).mean();
  terms[LossTerm::barrier_sets] =
      o.weight[LossTerm::barrier_sets] *
      (mean_penalty(out.initial, like, [&](const torch::Tensor& b) { return leaky(b + o.margin_initial); }) +
       mean_penalty(out.unsafe, like, [&](const torch::Tensor& b) { return leaky(o.margin_unsafe - b); }));
  terms[LossTerm::barrier_decrease] =
      o.weight[LossTerm::barrier_decrease] * leaky(out.B.derivative - o.margin_barrier_decrease).mean();
  terms[LossTerm::rollout_safety] = terms[LossTerm::obstacle_normal] = torch::zeros({}, like.options());
}

}  // namespace

torch::Tensor imitation_loss(const torch::Tensor& predicted, const torch::Tensor& velocity) {
  return (predicted - velocity).square().sum(1).mean();
}

LossValue joint_loss(Modules& networks, const BatchTensors& batch, const LossOptions& options) {
  const Outputs out = evaluate(networks, batch);
  PerTerm<torch::Tensor> terms;
  terms[LossTerm::imitation] =
      options.weight[LossTerm::imitation] * imitation_loss(out.velocity, batch.velocity);
  if (options.kind == "paper") {
    paper_terms(out, options, terms);
  } else {
    robust_terms(out, options, terms);
  }
  LossValue loss{.terms = {}, .total = torch::zeros({}, out.velocity.options())};
  for (const LossTerm term : all_loss_terms) {
    loss.terms[term] = terms[term].item<double>();
    loss.total = loss.total + terms[term];
  }
  return loss;
}

}  // namespace s2nnds
