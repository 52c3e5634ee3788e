// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/batch_sampler.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/interval.h"
#include "s2nnds/problem/phase_targets.h"

namespace s2nnds {
namespace {

// Shares of the workspace: the least distance of the samples around the goal, and the spread of the draws
// around a counterexample.
constexpr double kNearestToGoal = 1e-3;
constexpr double kJitter = 0.005;
constexpr int kBisections = 8;             // of the box around a sample
constexpr std::int64_t kBoundary = 4096;   // points of the obstacle's boundary to draw from
constexpr std::size_t kStock = 20000;      // points of each region, in many dimensions
constexpr Eigen::Index kCapacity = 20000;  // of a pool, whose oldest points leave: most have long been cured

void append_some(Points& batch, Eigen::Index& at, const Points& from, Eigen::Index count,
                 RandomStream& random) {
  for (Eigen::Index i = 0; i < count; ++i) batch.row(at++) = from.row(random.below(from.rows()));
}

// The age of a draw is log-uniform: counterexamples of early rounds outnumber the latest by far, and have
// mostly been cured. A little jitter (share of the box's sides) covers the set that a counterexample stands
// for.
void append_counterexamples(Points& batch, Eigen::Index& at, const Points& pool, Eigen::Index count,
                            const Box& within, double jitter, RandomStream& random) {
  for (Eigen::Index i = 0; i < count; ++i, ++at) {
    const double age = std::pow(static_cast<double>(pool.rows() + 1), random.uniform()) - 1.0;
    const auto back = std::min<Eigen::Index>(static_cast<Eigen::Index>(age), pool.rows() - 1);
    batch.row(at) = pool.row(pool.rows() - 1 - back);
    if (jitter == 0.0) continue;
    for (Eigen::Index k = 0; k < batch.cols(); ++k) {
      const double moved =
          batch(at, k) + jitter * 0.5 * (within.upper[k] - within.lower[k]) * random.normal();
      batch(at, k) = std::clamp(moved, within.lower[k], within.upper[k]);
    }
  }
}

Points some(const Points& from, Eigen::Index count, Eigen::Index dimension, RandomStream& random) {
  Points batch(from.rows() > 0 ? count : 0, dimension);
  Eigen::Index at = 0;
  append_some(batch, at, from, batch.rows(), random);
  return batch;
}

// Normal, across the velocity only: along it the demonstration's own samples tell f how fast to go.
Vector displacement(const Vector& velocity, double deviation, RandomStream& random) {
  Vector d(velocity.size());
  for (double& each : d) each = deviation * random.normal();
  const double squared_speed = velocity.squaredNorm();
  if (squared_speed > 0.0) d -= d.dot(velocity) / squared_speed * velocity;
  return d;
}

Points stacked(const Points& a, const Points& b) {
  if (b.rows() == 0) return a;
  Points all(a.rows() + b.rows(), a.cols());
  all << a, b;
  return all;
}

void append(Points& pool, const Points& more) {
  if (more.rows() == 0) return;
  Points all(pool.rows() + more.rows(), more.cols());
  all << pool, more;
  pool = all.bottomRows(std::min(all.rows(), kCapacity)).eval();
}

}  // namespace

BatchSampler::BatchSampler(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                           const TrainerOptions& options, const VelocityTargets& beside)
    : problem_(problem),
      options_(options.batch),
      initial_(sampler_of(problem.initial, problem.workspace)),
      unsafe_(sampler_of(problem.unsafe, problem.workspace)),
      workspace_margin_(sampler_of(problem.workspace_margin, problem.workspace)) {
  const double shares = options_.share_counterexamples + options_.share_band + options_.share_goal,
               margin = options.obstacle_margin;
  check(shares <= 1.0, "training.batch: the shares add up to {}, expected at most 1", shares);
  const Points position = stack_positions(demonstrations), velocity = stack_velocities(demonstrations);
  std::vector<Eigen::Index> kept;
  bool any_meets = false;
  Eigen::Index i = 0;
  for (const Demonstration& demonstration : demonstrations) {
    // A demonstration through the obstacle must be bent away from it, which takes room; but deep inside,
    // where no safe motion comes, f may follow it.
    const bool meets = problem.unsafe->level(demonstration.position).minCoeff() <= 0.0;
    any_meets = any_meets || meets;
    const Vector near = Vector::Constant(problem.dimension(), margin), reach = (meets ? 2.0 : 1.0) * near;
    for (Eigen::Index k = 0; k < demonstration.samples(); ++k, ++i) {
      const Vector x = position.row(i);
      if (margin == 0.0 || problem.unsafe->classify({x - near, x + near}) == Location::inside ||
          !may_meet(*problem.unsafe, {x - reach, x + reach}, kBisections))
        kept.push_back(i);
    }
  }
  check(!kept.empty(),
        "training: every demonstration sample lies within obstacle_margin = {} of the unsafe set", margin);
  left_out_ = position.rows() - static_cast<std::int64_t>(kept.size());
  shown_ = std::ssize(kept);
  const Points all_position = stacked(position, beside.position);
  const Vector reach = Vector::Constant(problem.dimension(), margin);
  for (; i < all_position.rows(); ++i) {
    const Vector x = all_position.row(i);
    if (margin == 0.0 || !may_meet(*problem.unsafe, {x - reach, x + reach}, kBisections)) kept.push_back(i);
  }
  drawn_ = std::ssize(kept);
  position_ = all_position(kept, Eigen::all);
  velocity_ = stacked(velocity, beside.velocity)(kept, Eigen::all);
  path_ = Points(0, problem.dimension());
  if (problem.has_phase()) {
    path_ = phase_path(problem, demonstrations);
  } else if (!any_meets) {
    path_ = position_.topRows(shown_);
  }
  jitter_ = (problem.initial->level(position_).array() <= 0.0)
                .select(Vector::Constant(position_.rows(), options_.start_jitter), 0.0);
  if (options.loss.weight[LossTerm::obstacle_normal] > 0.0) {
    RandomStream random(0, "obstacle's boundary");
    boundary_ = boundary_points(problem.unsafe, problem.workspace, kBoundary, random);
  }
  const Points none(0, problem.dimension());
  initial_stock_ = unsafe_stock_ = margin_stock_ = none;
  if (problem.dimension() > few_dimensions) {
    RandomStream random(0, "stock of the regions");
    for (const auto& [sampler, stock] :
         {std::pair{&initial_, &initial_stock_}, std::pair{&unsafe_, &unsafe_stock_},
          std::pair{&workspace_margin_, &margin_stock_}}) {
      if (*sampler) *stock = (*sampler)->sample(kStock, random);
    }
  }
  pools_ = {none, none, none};
  backtracked_ = {none, none, none};
  near_band_ = safe_ = unsafe_rollouts_ = none;
}

Points BatchSampler::uniform(std::int64_t count, RandomStream& random) const {
  return uniform_points(problem_.workspace, count, random);
}

Points BatchSampler::draw_workspace(RandomStream& random) const {
  const auto share = [&](double part, const Points& pool) {
    return pool.rows() > 0 ? static_cast<Eigen::Index>(part * static_cast<double>(options_.workspace)) : 0;
  };
  const Eigen::Index counterexamples = share(options_.share_counterexamples, pools_.workspace);
  const Eigen::Index band = share(options_.share_band, near_band_);
  const Eigen::Index goal = share(options_.share_goal, position_);
  Points x = uniform(options_.workspace, random);
  Eigen::Index at = 0;
  append_counterexamples(x, at, pools_.workspace, counterexamples, problem_.workspace, kJitter, random);
  append_some(x, at, near_band_, band, random);
  // The largest ball around the goal that the workspace holds.
  const double reach = next_up(problem_.workspace.upper.cwiseMin(-problem_.workspace.lower).minCoeff());
  for (Eigen::Index i = 0; i < goal; ++i, ++at) {
    const double radius = reach * std::exp(random.uniform(std::log(kNearestToGoal), 0.0));
    for (Eigen::Index k = 0; k < x.cols(); ++k) x(at, k) = random.normal();
    x.row(at) *= radius / x.row(at).norm();
  }
  return x;
}

Batch BatchSampler::draw(RandomStream& random) const {
  const Eigen::Index n = problem_.dimension();
  const Eigen::Index corrections = backtracked_.position.rows() > 0 ? correction_points : 0;
  Batch batch;
  batch.position.resize(options_.demonstrations + corrections, n);
  batch.velocity.resize(options_.demonstrations + corrections, n);
  for (Eigen::Index i = 0; i < options_.demonstrations; ++i) {
    const std::size_t sample = random.below(static_cast<std::size_t>(drawn_));
    batch.position.row(i) = position_.row(sample);
    batch.velocity.row(i) = velocity_.row(sample);
    if (jitter_[sample] == 0.0) continue;
    batch.position.row(i) += displacement(velocity_.row(sample), jitter_[sample], random).transpose();
  }
  for (Eigen::Index i = options_.demonstrations; i < batch.position.rows(); ++i) {
    const std::size_t chosen = random.below(backtracked_.position.rows());
    batch.position.row(i) = backtracked_.position.row(chosen);
    batch.velocity.row(i) = backtracked_.velocity.row(chosen);
  }
  batch.workspace = draw_workspace(random);
  const auto region = [&](const std::optional<RegionSampler>& sampler, const Points& stock,
                          const Points& pool, Eigen::Index count) {
    Points x(sampler ? count : 0, n);
    if (x.rows() == 0) return x;
    const Eigen::Index old = pool.rows() > 0 ? count / 2 : 0;
    x.bottomRows(count - old) =
        stock.rows() > 0 ? some(stock, count - old, n, random) : sampler->sample(count - old, random);
    Eigen::Index at = 0;
    append_counterexamples(x, at, pool, old, problem_.workspace, 0.0, random);
    return x;
  };
  batch.initial = stacked(region(initial_, initial_stock_, pools_.initial, options_.initial),
                          some(path_, options_.path, n, random));
  const Points obstacle = region(unsafe_, unsafe_stock_, pools_.unsafe, options_.unsafe);
  const Points margin = region(workspace_margin_, margin_stock_, pools_.unsafe, options_.unsafe);
  batch.unsafe.resize(obstacle.rows() + margin.rows(), n);
  batch.unsafe << obstacle, margin;
  batch.safe = some(safe_, labelled_points / 2, n, random);
  const Points ending = some(unsafe_rollouts_, labelled_points / 2, n, random),
               upstream = some(backtracked_.upstream, upstream_points, n, random);
  batch.unsafe_rollouts.resize(ending.rows() + upstream.rows(), n);
  batch.unsafe_rollouts << ending, upstream;
  batch.boundary.resize(boundary_.point.rows() > 0 ? boundary_points_drawn : 0, n);
  batch.normal.resize(batch.boundary.rows(), n);
  for (Eigen::Index i = 0; i < batch.boundary.rows(); ++i) {
    const std::size_t chosen = random.below(boundary_.point.rows());
    batch.boundary.row(i) = boundary_.point.row(chosen);
    batch.normal.row(i) = boundary_.normal.row(chosen);
  }
  return batch;
}

void BatchSampler::add(const Counterexamples& found) {
  for (std::size_t q = 0; q < all_conditions.size(); ++q) {
    Points* pool = &pools_.workspace;
    if (all_conditions[q] == Condition::initial) pool = &pools_.initial;
    if (all_conditions[q] == Condition::unsafe || all_conditions[q] == Condition::containment)
      pool = &pools_.unsafe;
    append(*pool, found.points[q]);
  }
}

void BatchSampler::set_labels(Points safe, Points unsafe_rollouts) {
  safe_ = std::move(safe);
  unsafe_rollouts_ = std::move(unsafe_rollouts);
}

}  // namespace s2nnds
