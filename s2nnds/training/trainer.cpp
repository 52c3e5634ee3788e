#include "s2nnds/training/trainer.h"

#include <torch/torch.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/networks/evaluator.h"
#include "s2nnds/training/flat_adam.h"
#include "s2nnds/training/joint_loss.h"
#include "s2nnds/training/level.h"
#include "s2nnds/training/loss_table.h"
#include "s2nnds/training/smoothed_velocity.h"
#include "s2nnds/training/warm_start.h"

namespace s2nnds {
namespace {

constexpr std::int64_t kBandCandidates = 20000;  // points among which those near {B = 0} are sought
// Factors of a weight after a round that was to keep the certificate and failed, and after one that did not.
constexpr double kRetreat = 0.5, kAdvance = 1.5;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// What a round trains, how fast and towards what.
struct RoundPlan {
  bool only_barrier = false;
  double rate = 1.0;  // factor of all rates
  LossOptions loss;
};

torch::Tensor tensor(const Points& points) {
  return torch::from_blob(const_cast<double*>(points.data()), {points.rows(), points.cols()}, torch::kFloat64)
      .to(torch::kFloat32);
}

// What f is fitted to.
std::vector<Demonstration> fitted_samples(const std::vector<Demonstration>& demonstrations,
                                          const TrainerOptions& options, std::uint64_t seed) {
  std::vector<Demonstration> all = smoothed(demonstrations, options.smoothing);
  for (Demonstration& copy : tube(demonstrations, options.tube, seed)) all.push_back(std::move(copy));
  return all;
}

// Without a obstacle_normal no boundary points are drawn.
BatchOptions batch_options(const TrainerOptions& options) {
  BatchOptions batch = options.batch;
  if (options.loss.weight[LossTerm::obstacle_normal] == 0.0) batch.boundary = 0;
  return batch;
}

}  // namespace

std::int64_t RoundSummary::counterexamples() const {
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

class Trainer::Impl {
 public:
  Impl(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
       const NetworkOptions& networks, const TrainerOptions& options, std::uint64_t seed)
      : problem_(problem),
        network_options_(networks),
        options_(options),
        seed_(seed),
        sampler_(problem, fitted_samples(demonstrations, options, seed), batch_options(options),
                 options.obstacle_margin),
        level_(problem, {.level_band = options.level_band, .reach = options.max_level_shift}) {
    RandomStream start_v(seed_, "start/V"), start_b(seed_, "start/B");
    modules_.f = make_field(1);
    modules_.V = Lyapunov(problem.dimension(), networks.V, start_v);
    modules_.B = Barrier(problem.dimension(), networks.B, start_b);
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
      const WarmStartSummary warm = warm_up();
      row.mse = warm.mse;
      row.seconds = seconds();
      summary.warm_start_mse = warm.mse;
      summary.warm_start_attempt = warm.attempt;
      summary.stopped = !report(row, owner);
    }
    while (!summary.stopped && !finished()) {
      const Networks before = networks();
      RoundSummary row = train_round();
      choose_level(row.round);
      search(row);
      if (row.stage != Stage::search && !row.clean()) set_networks(before);
      row.seconds = seconds();
      summary.stopped = !report(row, owner);
    }
    summary.rounds = history_.back().round;
    summary.clean = had_clean_round();
    summary.seconds = seconds();
    return summary;
  }

  bool finished() const {
    if (!had_clean_round()) return history_.back().round >= options_.rounds;
    return next_stage() == Stage::enlarge &&
           rounds_in(Stage::enlarge) >= (uses_labels() ? options_.enlarge_rounds : 0);
  }

  std::int64_t rounds_in(Stage stage) const {
    return std::count_if(history_.begin(), history_.end(),
                         [=](const RoundSummary& row) { return row.stage == stage; });
  }

  Stage next_stage() const {
    if (!had_clean_round()) return Stage::search;
    return rounds_in(Stage::imitation_finetune) < options_.imitation_finetune_rounds
               ? Stage::imitation_finetune
               : Stage::enlarge;
  }

  bool had_clean_round() const {
    return std::any_of(history_.begin(), history_.end(), [&](const RoundSummary& row) {
      return row.round >= options_.min_rounds && row.clean();
    });
  }

  Networks networks() const {
    return {modules_.f->snapshot(), modules_.V->snapshot(), modules_.B->snapshot()};
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
  std::function<bool(const RoundSummary&, const Trainer&)> callback;

 private:
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

  bool report(const RoundSummary& row, const Trainer& owner) {
    history_.push_back(row);
    return !callback || callback(row, owner);
  }

  WarmStartSummary warm_up() {
    const torch::Tensor position = tensor(sampler_.position()), velocity = tensor(sampler_.velocity());
    return warm_start(modules_.f, position, velocity, sampler_.jitter(), options_.warm_start,
                      engine_from(options_.engine), seed_,
                      [&](std::int64_t attempt) { return make_field(attempt); });
  }

  RoundSummary train_round() {
    RoundSummary row;
    const std::int64_t round = row.round = static_cast<std::int64_t>(history_.size());
    row.stage = next_stage();
    label(row);
    seek_backtracked(row.stage);
    if (row.stage == Stage::search && starts_anew(round) && options_.redraw_barrier) redraw_barrier(round);
    const RoundPlan plan = plan_of(round, row.stage);
    // Each round starts afresh, so that a checkpoint needs no optimiser state.
    std::vector<FlatAdam> optimizers(3, FlatAdam(0.0, options_.clip));
    optimizers[0] = FlatAdam(options_.weight_decay, options_.clip);
    torch::Tensor parameters[] = {modules_.f->network->theta, modules_.V->network->theta,
                                  modules_.B->network->theta};
    const double rates[] = {options_.rate_f, options_.rate_certificates, options_.rate_certificates};
    JointLoss loss(modules_, loss_table(plan.loss), plan.loss, engine_from(options_.engine),
                   plan.only_barrier ? Trains::barrier : Trains::all);
    const std::size_t first_trained = plan.only_barrier ? 2 : 0;
    RandomStream random(seed_, "batches", round), candidates(seed_, "near band", round);
    const auto seeks_band = [&](std::int64_t step) { return step % options_.batch.band_refresh == 0; };
    BatchTensors batch, next;
    SideTask drawing;  // of the next step's batch, while a step runs
    for (std::int64_t step = 0; step < options_.steps; ++step) {
      if (seeks_band(step)) {
        seek_band(candidates);
        batch = transform<torch::Tensor>(sampler_.draw(random), tensor);
      } else {
        drawing.wait();
        batch = std::move(next);
      }
      if (step + 1 < options_.steps && !seeks_band(step + 1)) {
        drawing.start([&] { next = transform<torch::Tensor>(sampler_.draw(random), tensor); });
      }
      const LossValue value = loss(batch);
      for (torch::Tensor& parameter : parameters) parameter.mutable_grad() = torch::Tensor();
      value.total.backward();
      for (std::size_t k = first_trained; k < optimizers.size(); ++k) {
        optimizers[k].step(plan.rate * annealed(step) * rates[k], parameters[k].numel(),
                           parameters[k].grad().data_ptr<float>(), parameters[k].data_ptr<float>());
      }
      const double share = 1.0 / static_cast<double>(options_.steps);
      row.loss += share * value.total.item<double>();
      for (const LossTerm term : all_loss_terms) row.loss_terms[term] += share * value.terms[term];
    }
    const double weight = plan.loss.weight[LossTerm::imitation];
    row.mse = weight > 0.0 ? row.loss_terms[LossTerm::imitation] / weight : history_.back().mse;
    return row;
  }

  // The rates are back at their full height.
  bool starts_anew(std::int64_t round) const { return round > 1 && (round - 1) % options_.rate_period == 0; }

  void redraw_barrier(std::int64_t round) {
    RandomStream start(seed_, "start/B", round);
    modules_.B = Barrier(problem_.dimension(), network_options_.B, start);
  }

  RoundPlan plan_of(std::int64_t round, Stage stage) const {
    if (stage == Stage::enlarge) return enlarge_plan();
    if (stage == Stage::imitation_finetune) return imitation_finetune_plan();
    const auto age = static_cast<double>((round - 1) % options_.rate_period);
    RoundPlan plan = {false, std::max(options_.rate_floor, std::pow(options_.rate_decay, age)),
                      options_.loss};
    const auto restarts = static_cast<double>((round - 1) / options_.rate_period);
    plan.loss.weight[LossTerm::imitation] *= std::pow(options_.restart_mse, restarts);
    plan.loss.weight[LossTerm::rollout_safety] *= std::pow(options_.restart_rollout_safety, restarts);
    plan.loss.weight[LossTerm::obstacle_normal] *= std::pow(options_.restart_rollout_safety, restarts);
    const std::int64_t refining = starts_anew(round) ? 0 : refine_round();
    if (refining == 0) return plan;
    plan.rate *= options_.refine_rate;
    plan.loss.weight[LossTerm::rollout_safety] *= std::pow(options_.refine_labels, refining);
    plan.loss.weight[LossTerm::obstacle_normal] *= std::pow(options_.refine_labels, refining);
    plan.loss.weight[LossTerm::barrier_decrease] *= options_.refine_band;
    return plan;
  }

  // Which one in a row of rounds that mend the next round is; 0 if it does not mend. A row that ends without
  // success is followed by a round at full rates: what is left may lie in the shape of the functions.
  std::int64_t refine_round() const {
    const auto other = std::find_if(history_.rbegin(), history_.rend(),
                                    [&](const RoundSummary& row) { return !nearly_clean(row); });
    return std::distance(history_.rbegin(), other) % (options_.refine_rounds + 1);
  }

  // Random search found few counterexamples; those that are left may be none of its own.
  bool nearly_clean(const RoundSummary& row) const {
    if (row.round < options_.min_rounds || row.stage != Stage::search) return false;
    return row.counterexamples() < options_.refine_below || row.first_found == 0;
  }

  // A weight's factor: `first`, less after each round of the stage that failed.
  double careful(Stage stage, double first) const {
    double factor = first;
    for (const RoundSummary& row : history_) {
      if (row.stage == stage)
        factor = std::clamp(factor * (row.clean() ? kAdvance : kRetreat), 1.0, std::max(1.0, first));
    }
    return factor;
  }

  RoundPlan imitation_finetune_plan() const {
    RoundPlan plan = {false, options_.imitation_finetune_rate, options_.loss};
    plan.loss.weight[LossTerm::imitation] *=
        careful(Stage::imitation_finetune, options_.imitation_finetune_mse);
    return plan;
  }

  // What concerns B alone.
  RoundPlan enlarge_plan() const {
    RoundPlan plan = {true, options_.enlarge_rate, options_.loss};
    plan.loss.weight[LossTerm::imitation] = plan.loss.weight[LossTerm::lyapunov] =
        plan.loss.weight[LossTerm::obstacle_normal] = 0.0;
    plan.loss.weight[LossTerm::rollout_safety] *= careful(Stage::enlarge, options_.enlarge_labels);
    plan.loss.weight[LossTerm::barrier_sets] *= options_.enlarge_margins;
    plan.loss.weight[LossTerm::barrier_decrease] *= options_.enlarge_margins;
    return plan;
  }

  // The share of the round's rate at a step: half a cosine from 1 down to rate_end, after a linear rise,
  // since the optimiser's first steps know nothing of the gradient's size and move every weight by the whole
  // rate.
  double annealed(std::int64_t step) const {
    const double progress = static_cast<double>(step) / static_cast<double>(options_.steps);
    const double fall = 0.5 * (1.0 + std::cos(std::numbers::pi * progress));
    const double rise =
        std::min(1.0, static_cast<double>(step + 1) / static_cast<double>(options_.rate_rise));
    return rise * (options_.rate_end + (1.0 - options_.rate_end) * fall);
  }

  bool uses_labels() const {
    return labels && options_.rollout_points > 0 && options_.loss.weight[LossTerm::rollout_safety] > 0.0 &&
           options_.loss.kind != "paper";
  }

  // Rollout labels of fresh points under the f that the round starts with.
  void label(RoundSummary& row) {
    if (!uses_labels()) return;
    RandomStream random(seed_, "labels", row.round);
    const Points starts = sampler_.uniform(options_.rollout_points, random);
    const std::vector<bool> is_safe = labels(modules_.f->snapshot(), starts);
    std::vector<Eigen::Index> safe, unsafe_rollouts;
    for (Eigen::Index i = 0; i < starts.rows(); ++i) (is_safe[i] ? safe : unsafe_rollouts).push_back(i);
    row.safe_share = static_cast<double>(safe.size()) / static_cast<double>(starts.rows());
    sampler_.set_labels(starts(safe, Eigen::all), starts(unsafe_rollouts, Eigen::all));
  }

  // Without the band's weight nothing makes B a barrier.
  void seek_backtracked(Stage stage) {
    const Points none(0, problem_.dimension());
    Backtracked found = {none, none, none};
    if (options_.backtrack_motions > 0 && options_.loss.weight[LossTerm::barrier_decrease] > 0.0 &&
        stage == Stage::search) {
      found = backtrack(networks(), problem_, sampler_.pools().workspace, sampler_.position(),
                        sampler_.velocity(),
                        {options_.backtrack_motions, options_.level_band, options_.backtrack_gain});
    }
    sampler_.set_backtracked(std::move(found));
  }

  void seek_band(RandomStream& random) {
    if (options_.batch.share_band == 0.0) return;
    const Points candidates = sampler_.uniform(kBandCandidates, random);
    const Points value = BasicEvaluator<float>(modules_.B->snapshot()).value(candidates);
    std::vector<Eigen::Index> near;
    for (Eigen::Index i = 0; i < candidates.rows(); ++i) {
      if (std::abs(value(i, 0)) < options_.batch.band_near) near.push_back(i);
    }
    sampler_.set_near_band(candidates(near, Eigen::all));
  }

  void choose_level(std::int64_t round) {
    if (options_.max_level_shift == 0.0) return;
    RandomStream random(seed_, "level", round);
    NetworkWeights B = modules_.B->snapshot();
    Vector& bias = B.layers.back().bias;
    if (bias.size() == 0) return;
    if (const auto c = level_.largest(networks(), random)) {
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
      if (source == sources.front()) row.first_found = found.total();
      for (std::size_t q = 0; q < row.counts.size(); ++q) row.counts[q] += found.counts[q];
      sampler_.add(found, options_.pool_additions, options_.pool_capacity);
    }
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
void Trainer::set_rollout_labels(RolloutLabels labels) { impl_->labels = std::move(labels); }
void Trainer::on_round(std::function<bool(const RoundSummary&, const Trainer&)> callback) {
  impl_->callback = std::move(callback);
}
TrainerSummary Trainer::run() { return impl_->run(*this); }
TrainerState Trainer::state() const { return impl_->state(); }
void Trainer::restore(const TrainerState& state) { impl_->restore(state); }
Networks Trainer::networks() const { return impl_->networks(); }

}  // namespace s2nnds
