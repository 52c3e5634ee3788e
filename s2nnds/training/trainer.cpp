// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/trainer.h"

#include <torch/types.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/networks/evaluator.h"
#include "s2nnds/problem/detour.h"
#include "s2nnds/problem/funnel.h"
#include "s2nnds/problem/phase_targets.h"
#include "s2nnds/training/flat_adam.h"
#include "s2nnds/training/joint_loss.h"
#include "s2nnds/training/level.h"
#include "s2nnds/training/lipschitz_limit.h"
#include "s2nnds/training/loss_table.h"
#include "s2nnds/training/plan.h"
#include "s2nnds/training/smoothed_velocity.h"
#include "s2nnds/training/warm_start.h"

namespace s2nnds {
namespace {

// Points near {B = 0} are those with |B| below kBandNear of kBandCandidates uniform ones, sought anew every
// kBandRefresh steps, in which B moves little: wider than the level band, so that Bdot < 0 holds around it
// too.
constexpr std::int64_t kBandCandidates = 20000;
constexpr double kBandNear = 0.06;
constexpr std::int64_t kBandRefresh = 100;

// Points with B below minus this count as safe: the loss of a safe label is 0 there. Of so many times the
// usual number of points the others, a fifth or so, are labelled where the safe set grows.
constexpr double kSettled = 0.05;
constexpr std::int64_t kMoreLabels = 2;

// By which the volume of {B <= 0} is told. They are the same in all rounds, so that few show a change.
constexpr std::int64_t kVolumePoints = 20000;

// Within a round the rates fall to this share of themselves: what noise of the steps leaves behind looks like
// violations that no training removes.
constexpr double kRateAtEnd = 0.05;
// Steps of a round over which the rates rise from 0: the optimiser's first steps know nothing of the
// gradient's size and move every weight by the whole rate.
constexpr std::int64_t kRateRise = 50;

constexpr std::int64_t kStarts = 32;  // in X0, whose motions are like those of the demonstrations

// Of power iteration from fixed vectors; from step to step one is enough.
constexpr int kFirstIterations = 30;

// Of the change of a round that did not end clean, what is tried instead.
constexpr double kParts[] = {0.5, 0.25};

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

torch::Tensor tensor(const Points& points) {
  return torch::from_blob(const_cast<double*>(points.data()), {points.rows(), points.cols()}, torch::kFloat64)
      .to(torch::kFloat32);
}

// The share of the round's rate at a step: half a cosine from 1 down to kRateAtEnd, after a linear rise.
double annealed(std::int64_t step, std::int64_t steps) {
  const double progress = static_cast<double>(step) / static_cast<double>(steps);
  const double fall = 0.5 * (1.0 + std::cos(std::numbers::pi * progress));
  const double rise = std::min(1.0, static_cast<double>(step + 1) / static_cast<double>(kRateRise));
  return rise * (kRateAtEnd + (1.0 - kRateAtEnd) * fall);
}

// To targets of velocities (VelocityTargets, Backtracked), further ones.
void append(auto& to, const VelocityTargets& more) {
  Points position(to.position.rows() + more.position.rows(), to.position.cols()), velocity = position;
  position << to.position, more.position;
  velocity << to.velocity, more.velocity;
  to.position = std::move(position);
  to.velocity = std::move(velocity);
}

// The demonstrations, and motions like them from starts in X0 that they do not show.
std::vector<Demonstration> with_start_paths(std::vector<Demonstration> demonstrations,
                                            const SafetyProblem& problem, double share, std::uint64_t seed) {
  if (share == 0.0) return demonstrations;
  RandomStream random(seed, "start paths");
  const Points starts = spread_starts(problem, demonstrations, kStarts, random);
  const double samples = share * static_cast<double>(stack_positions(demonstrations).rows()) / kStarts;
  for (Demonstration& path :
       start_paths(demonstrations, starts, std::max<std::int64_t>(2, std::llround(samples))))
    demonstrations.push_back(std::move(path));
  return demonstrations;
}

BatchSampler make_sampler(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                          const TrainerOptions& options, std::uint64_t seed) {
  const std::vector<Demonstration> shown = smoothed(demonstrations, options.smoothing);
  RandomStream random(seed, "funnel");
  const std::int64_t count =
      std::llround(options.funnel * static_cast<double>(stack_positions(shown).rows()));
  VelocityTargets beside = problem.has_phase() ? phase_targets(problem, shown, count, random)
                                               : funnel_samples(problem, shown, count, random);
  if (options.detour > 0.0) append(beside, detour_samples(problem, shown, options.detour));
  return BatchSampler(problem, with_start_paths(shown, problem, options.start_paths, seed), options, beside);
}

NetworkWeights between(NetworkWeights a, const NetworkWeights& b, double part) {
  for (std::size_t k = 0; k < a.layers.size(); ++k) {
    a.layers[k].weight += part * (b.layers[k].weight - a.layers[k].weight);
    if (a.layers[k].bias.size() > 0) a.layers[k].bias += part * (b.layers[k].bias - a.layers[k].bias);
  }
  return a;
}

// Of the points, those in {B <= 0}.
double share_within(const NetworkWeights& B, const Points& points) {
  const Points value = BasicEvaluator<float>(B).value(points);
  return static_cast<double>((value.array() <= 0.0).count()) / static_cast<double>(points.rows());
}

// The networks whose weights lie between those of a (part 0) and b (part 1).
Networks between(const Networks& a, const Networks& b, double part) {
  return {between(a.f, b.f, part), between(a.V, b.V, part), between(a.B, b.B, part), a.decay};
}

// In many dimensions (more than few_dimensions) a round takes so many times as many steps: what is wrong is on more and
// smaller sets. Labels of rollouts count so much as usual, and there are so many fewer: nearly all uniform points lie next
// to the workspace's edge, where the margin must be kept.
constexpr std::int64_t kStepsInMany = 2, kFewerLabelsInMany = 4;
constexpr double kLabelsInMany = 0.3;
// Boxes of many dimensions around a sample are found off an obstacle only if they are small, and a detour in one of the few
// directions that are tried is seldom one.
constexpr double kObstacleMarginInMany = 1.0 / 30.0;

// Motions of a projected f converge whatever they pass: what f is taught along those that are followed back would only
// spoil it.
TrainerOptions adjusted(TrainerOptions options, const VectorFieldOptions& f, std::int64_t dimension) {
  options.loss.projection = f.projection();
  if (options.loss.projection > 0.0) options.backtrack = false;
  if (dimension <= few_dimensions) return options;
  options.steps *= kStepsInMany;
  options.obstacle_margin *= kObstacleMarginInMany;
  options.detour = 0.0;
  options.loss.weight[LossTerm::rollout_safety] *= kLabelsInMany;
  if (options.rollout_points > 0)
    options.rollout_points = std::max<std::int64_t>(1, options.rollout_points / kFewerLabelsInMany);
  return options;
}

bool keeps(const RoundPlan& round, const RoundSummary& row) {
  return row.clean() && row.deviation <= round.largest_deviation;
}

// The optimisers of a round. Each round starts afresh, so that a checkpoint needs no optimiser state.
class Descent {
 public:
  Descent(const Modules& modules, const TrainerOptions& options, const Trains& trains)
      : trained_{trains.f, trains.V, trains.B},
        parameters_{modules.f->network->theta, modules.V->network->theta, modules.B->network->theta},
        rates_{options.rate_f, options.rate_certificates, options.rate_certificates},
        optimizers_{FlatAdam(options.weight_decay), FlatAdam(0.0), FlatAdam(0.0)} {
    if (!trains.V || modules.V->head() != Head::diffeomorphism) return;
    limit_.emplace(modules.V->network->shapes(), modules.V->lipschitz());
    limit_->keep(parameters_[1].data_ptr<float>(), kFirstIterations);
  }

  // One step of the networks that are trained, at `factor` times their rates.
  void step(const torch::Tensor& loss, double factor) {
    for (torch::Tensor& parameter : parameters_) parameter.mutable_grad() = torch::Tensor();
    loss.backward();
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      if (!trained_[k]) continue;
      optimizers_[k].step(factor * rates_[k], parameters_[k].numel(), parameters_[k].grad().data_ptr<float>(),
                          parameters_[k].data_ptr<float>());
    }
    if (limit_) limit_->keep(parameters_[1].data_ptr<float>(), 1);
  }
  // After the last step.
  void finish() {
    if (limit_) limit_->keep(parameters_[1].data_ptr<float>(), kFirstIterations);
  }

 private:
  std::array<bool, 3> trained_;  // of f, V and B, as what follows
  std::array<torch::Tensor, 3> parameters_;
  std::array<double, 3> rates_;
  std::array<FlatAdam, 3> optimizers_;
  std::optional<LipschitzLimit> limit_;  // of V's layers
};

}  // namespace

class Trainer::Impl {
 public:
  Impl(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
       const NetworkOptions& networks, const TrainerOptions& options, std::uint64_t seed)
      : problem_(problem),
        network_options_(networks),
        options_(adjusted(options, networks.f, problem.dimension())),
        seed_(seed),
        sampler_(make_sampler(problem, demonstrations, options_, seed)),
        level_(problem, {.level_band = options.level_band,
                         .reach = options.max_level_shift,
                         .execution = options.loss.execution,
                         .margin_initial = options.loss.margin_initial,
                         .margin_unsafe = options.loss.margin_unsafe,
                         .margin_decrease = options.loss.margin_barrier_decrease}) {
    RandomStream start_v(seed_, "start/V"), start_b(seed_, "start/B");
    modules_.f = make_field(1);
    modules_.V = Lyapunov(problem.dimension(), networks.V, start_v);
    modules_.B = make_barrier(start_b);
    preparation_ = seconds_since(begin_);
  }

  TrainerSummary run(const Trainer& owner) {
    const auto begin = Clock::now();
    const double earlier =
        std::exchange(preparation_, 0.0) + (history_.empty() ? 0.0 : history_.back().seconds);
    const auto seconds = [&] { return earlier + seconds_since(begin); };
    TrainerSummary summary;
    summary.left_out_samples = sampler_.left_out_samples();
    if (history_.empty()) {
      RoundSummary row;
      warm_up();
      row.mse = mse_of_shown();
      row.seconds = seconds();
      summary.stopped = !report(row, owner);
    }
    for (RoundPlan next = planned(); !summary.stopped && !next.finished; next = planned()) {
      const Networks before = networks();
      RoundSummary row = train_round(next);
      choose_level(row.round);
      search(row);
      for (std::int64_t k = 1; k <= next.repairs && is_repairable(row); ++k) repair(row, next, k);
      if (next.undone_unless_clean && !keeps(next, row)) go_back_towards(before, next, row);
      if (next.stage == Stage::enlarge) go_back_if_smaller(before, next, row);
      row.seconds = seconds();
      summary.stopped = !report(row, owner);
    }
    summary.rounds = history_.back().round;
    summary.clean = has_clean_round(history_, options_);
    summary.seconds = seconds();
    return summary;
  }

  Networks networks() const {
    return {modules_.f->snapshot(), modules_.V->snapshot(), modules_.B->snapshot(),
            network_options_.f.projection()};
  }

  TrainerState state() const { return {networks(), sampler_.pools(), history_}; }

  void restore(const TrainerState& state) {
    for (std::size_t k = 0; k < state.history.size(); ++k) {
      check(state.history[k].round == static_cast<std::int64_t>(k),
            "trainer: history row {} is of round {}, expected {}", k, state.history[k].round, k);
    }
    set_networks(state.networks);
    sampler_.set_pools(state.pools);
    history_ = state.history;
  }

  std::vector<std::shared_ptr<CounterexampleSource>> sources;
  RolloutLabels labels;
  MotionCorrections corrections;
  RoundLook look;
  std::function<bool(const RoundSummary&, const Trainer&)> callback;

 private:
  RoundPlan planned() const {
    TrainerOptions options = options_;
    if (!labels) options.rollout_points = 0;
    return plan(history_, options);
  }

  void set_networks(const Networks& networks) {
    modules_.f->restore(networks.f);
    modules_.V->restore(networks.V);
    modules_.B->restore(networks.B);
  }

  VectorField make_field(std::int64_t attempt) const {
    RandomStream start(seed_, "start/f", attempt);
    VectorField f(problem_.dimension(), network_options_.f, start);
    return f;
  }

  Barrier make_barrier(RandomStream& start) const {
    const BarrierOptions& options = network_options_.B;
    Barrier B(problem_.dimension(), options, start);
    const LayerShape first = B->network->shapes().front();
    const bool fits =
        first.inputs == 2 && first.outputs > 4 && first.bias && first.activation == Activation::tanh;
    if (options.wall_slope > 0.0 && fits) B->lay_along(problem_.contained, options.wall_slope);
    return B;
  }

  bool report(const RoundSummary& row, const Trainer& owner) {
    history_.push_back(row);
    return !callback || callback(row, owner);
  }

  void warm_up() {
    const torch::Tensor position = tensor(sampler_.position()), velocity = tensor(sampler_.velocity());
    warm_start(modules_.f, position, velocity, sampler_.jitter(), options_.warm_start,
               engine_from(options_.engine), seed_,
               [&](std::int64_t attempt) { return make_field(attempt); });
  }

  double mse_of_shown() const {
    const Eigen::Index count = sampler_.shown_samples();
    const Points error =
        BasicEvaluator<float>(modules_.f->snapshot()).value(sampler_.position().topRows(count)) -
        sampler_.velocity().topRows(count);
    return error.rowwise().squaredNorm().mean();
  }

  RoundSummary train_round(const RoundPlan& now) {
    RoundSummary row;
    const std::int64_t round = row.round = std::ssize(history_);
    row.stage = now.stage;
    if (now.labels_rollouts) label(row, now.stage == Stage::enlarge);
    seek_backtracked(now);
    sampler_.set_draws_beside(!now.undone_unless_clean);
    if (now.starts_anew) start_anew(round);
    descend(row, now, now.trains.f ? options_.steps : options_.enlarge_steps, 0);
    const double weight = now.loss.weight[LossTerm::imitation];
    row.mse = weight > 0.0 ? row.loss_terms[LossTerm::imitation] / weight : history_.back().mse;
    return row;
  }

  // The steps of a round, or of its k-th repair. Adds their mean losses to the row.
  void descend(RoundSummary& row, const RoundPlan& now, std::int64_t steps, std::int64_t repair) {
    const std::int64_t round = row.round + (repair << 32);
    Descent descent(modules_, options_, now.trains);
    JointLoss loss(modules_, loss_table(now.loss), now.loss, engine_from(options_.engine), now.trains);
    RandomStream random(seed_, "batches", round), candidates(seed_, "near band", round);
    const auto seeks_band = [](std::int64_t step) { return step % kBandRefresh == 0; };
    const auto draw = [&] { return transform<torch::Tensor>(sampler_.draw(random), tensor); };
    BatchTensors batch, next;
    SideTask drawing;  // of the next step's batch, while a step runs
    for (std::int64_t step = 0; step < steps; ++step) {
      if (seeks_band(step)) {
        seek_band(candidates);
        batch = draw();
      } else {
        drawing.wait();
        batch = std::move(next);
      }
      if (step + 1 < steps && !seeks_band(step + 1)) drawing.start([&] { next = draw(); });
      const LossValue value = loss(batch);
      descent.step(value.total, now.rate * annealed(step, steps));
      if (repair > 0) continue;
      const double share = 1.0 / static_cast<double>(steps);
      row.loss += share * value.total.item<double>();
      for (const LossTerm term : all_loss_terms) row.loss_terms[term] += share * value.terms[term];
    }
    descent.finish();
  }

  // V and B are trained on what the search after the round found, and the search made anew.
  void repair(RoundSummary& row, const RoundPlan& round, std::int64_t k) {
    const RoundPlan plan = repair_plan(round, row, options_);
    descend(row, plan, std::max<std::int64_t>(1, options_.steps / 2), k);
    if (plan.trains.B) choose_level(row.round + (k << 32));
    search_anew(row);
  }

  // Of the way from `before` to what the round made, the largest part that ends clean: a half, a quarter,
  // none.
  void go_back_towards(const Networks& before, const RoundPlan& round, RoundSummary& row) {
    const Networks after = networks();
    const RoundSummary whole = row;
    for (const double part : kParts) {
      set_networks(between(before, after, part));
      keep_lipschitz();
      search_anew(row);
      if (keeps(round, row)) return;
    }
    set_networks(before);
    row = whole;
  }

  // Where {B <= 0} has lost too much. Tells its volume.
  void go_back_if_smaller(const Networks& before, const RoundPlan& round, RoundSummary& row) {
    RandomStream random(seed_, "volume");
    const Points points = sampler_.uniform(kVolumePoints, random);
    const double earlier = share_within(before.B, points);
    row.volume = share_within(modules_.B->snapshot(), points);
    if (row.volume >= (1.0 - round.may_lose) * earlier) return;
    set_networks(before);
    row.volume = earlier;
  }

  // Between two V within the limit there may be one beyond it.
  void keep_lipschitz() {
    if (modules_.V->head() != Head::diffeomorphism) return;
    LipschitzLimit(modules_.V->network->shapes(), modules_.V->lipschitz())
        .keep(modules_.V->network->theta.data_ptr<float>(), kFirstIterations);
  }

  void search_anew(RoundSummary& row) {
    row.counts = {};
    row.found_by_sampling = row.islands = row.equilibria = 0;
    row.deviation = 0.0;
    search(row);
  }

  // f as after the warm start, V and B drawn anew: low rates do not change a bad shape.
  void start_anew(std::int64_t round) {
    RandomStream start_v(seed_, "start/V", round), start_b(seed_, "start/B", round);
    warm_up();
    modules_.V = Lyapunov(problem_.dimension(), network_options_.V, start_v);
    modules_.B = make_barrier(start_b);
  }

  // Of uniform points those that B does not hold safe, at least one.
  Points not_settled(const Points& points) const {
    const Points value = BasicEvaluator<float>(modules_.B->snapshot()).value(points);
    std::vector<Eigen::Index> undecided;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      if (!(value(i, 0) < -kSettled)) undecided.push_back(i);
    }
    if (undecided.empty()) return points.topRows(1);
    return points(undecided, Eigen::all);
  }

  // Rollout labels of fresh points under the f that the round starts with. Where the safe set
  // grows, only of those that B does not hold safe yet: that the others are is certified.
  void label(RoundSummary& row, bool only_undecided) {
    RandomStream random(seed_, "labels", row.round);
    const Points starts = only_undecided
                              ? not_settled(sampler_.uniform(kMoreLabels * options_.rollout_points, random))
                              : sampler_.uniform(options_.rollout_points, random);
    const std::vector<bool> is_safe = labels(networks().dynamics(), starts);
    std::vector<Eigen::Index> safe, unsafe_rollouts;
    for (Eigen::Index i = 0; i < starts.rows(); ++i) (is_safe[i] ? safe : unsafe_rollouts).push_back(i);
    row.safe_share = static_cast<double>(safe.size()) / static_cast<double>(starts.rows());
    sampler_.set_labels(starts(safe, Eigen::all), starts(unsafe_rollouts, Eigen::all));
  }

  void seek_backtracked(const RoundPlan& now) {
    const Points none(0, problem_.dimension());
    Backtracked found = {none, none, none};
    if (now.backtracks) {
      found = backtrack(networks(), problem_, sampler_.pools().workspace, sampler_.position(),
                        sampler_.velocity(), {.level_band = options_.level_band});
    }
    if (corrections && now.trains.f) append(found, corrections(networks().dynamics(), std::ssize(history_)));
    sampler_.set_backtracked(std::move(found));
  }

  void seek_band(RandomStream& random) {
    if (options_.batch.share_band == 0.0) return;
    const Points candidates = sampler_.uniform(kBandCandidates, random);
    const Points value = BasicEvaluator<float>(modules_.B->snapshot()).value(candidates);
    std::vector<Eigen::Index> near;
    for (Eigen::Index i = 0; i < candidates.rows(); ++i) {
      if (std::abs(value(i, 0)) < kBandNear) near.push_back(i);
    }
    sampler_.set_near_band(candidates(near, Eigen::all));
  }

  void choose_level(std::int64_t round) {
    if (options_.max_level_shift == 0.0) return;
    RandomStream random(seed_, "level", round);
    NetworkWeights B = modules_.B->snapshot();
    Vector& bias = B.layers.back().bias;
    if (bias.size() == 0) return;
    const bool many = problem_.dimension() > few_dimensions;
    if (const auto c = many ? level_.safest(networks(), random) : level_.largest(networks(), random)) {
      bias[0] -= *c;
      modules_.B->restore(B);
    }
  }

  void search(RoundSummary& row) {
    const Networks current = networks();
    for (const auto& source : sources) {
      if (source->only_when_clean() && (row.counterexamples() > 0 || row.round < options_.min_rounds))
        continue;
      const Counterexamples found = source->find(current, problem_, options_.level_band, seed_, row.round);
      if (source->samples_uniformly()) row.found_by_sampling += found.total();
      for (std::size_t q = 0; q < row.counts.size(); ++q) row.counts[q] += found.counts[q];
      sampler_.add(found);
    }
    if (look) look(current, row);
    const CounterexamplePools& pools = sampler_.pools();
    row.pool = pools.workspace.rows() + pools.initial.rows() + pools.unsafe.rows();
  }

  const Clock::time_point begin_ = Clock::now();
  double preparation_ = 0.0;  // seconds that the constructor took
  const SafetyProblem& problem_;
  NetworkOptions network_options_;
  TrainerOptions options_;
  std::uint64_t seed_;
  BatchSampler sampler_;
  LevelChoice level_;
  Modules modules_;
  std::vector<RoundSummary> history_;
};

Trainer::Trainer(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                 const NetworkOptions& networks, const TrainerOptions& options, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(problem, demonstrations, networks, options, seed)) {}
Trainer::~Trainer() = default;
Trainer::Trainer(Trainer&&) noexcept = default;

void Trainer::add_source(std::shared_ptr<CounterexampleSource> source) {
  impl_->sources.push_back(std::move(source));
}
void Trainer::set_corrections(MotionCorrections corrections) { impl_->corrections = std::move(corrections); }
void Trainer::set_look(RoundLook look) { impl_->look = std::move(look); }
void Trainer::set_rollout_labels(RolloutLabels labels) { impl_->labels = std::move(labels); }
void Trainer::on_round(std::function<bool(const RoundSummary&, const Trainer&)> callback) {
  impl_->callback = std::move(callback);
}
TrainerSummary Trainer::run() { return impl_->run(*this); }
TrainerState Trainer::state() const { return impl_->state(); }
void Trainer::restore(const TrainerState& state) { impl_->restore(state); }
Networks Trainer::networks() const { return impl_->networks(); }

}  // namespace s2nnds
