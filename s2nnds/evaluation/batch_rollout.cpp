// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numeric>

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/evaluation/rollout_events.h"

namespace s2nnds {
namespace {

constexpr double kFirstStep = 0.02;
constexpr double kShortestStep = 1e-9;
constexpr int kMostSteps = 2'000;     // a motion that takes more chatters, and would hold up all others
constexpr Eigen::Index kChunk = 512;  // starts that advance together
// Of a level, the share that may be used up before it is computed anew; the rest covers rounding.
constexpr double kSureShare = 1.0 - 1e-9;

// Many motions at once. Each has its own time and step; those that are decided leave the batch, so that the
// rest stays packed for the network.
class BatchRollout {
 public:
  BatchRollout(const StateFunction& field, const SafetyProblem& problem, const Points& starts,
               const BatchRolloutOptions& options)
      : field_(field),
        unsafe_(*problem.unsafe),
        events_(problem, options.goal_radius, true, true),
        options_(options),
        safe_(static_cast<std::size_t>(starts.rows()), false),
        start_index_(safe_.size()),
        position_(starts),
        velocity_(field_.quick_value(starts)),
        time_(Vector::Zero(starts.rows())),
        step_(Vector::Constant(starts.rows(), std::min(options.step, kFirstStep))),
        clear_(Vector::Zero(starts.rows())) {
    std::iota(start_index_.begin(), start_index_.end(), std::size_t{0});
    std::vector<Outcome> outcomes(safe_.size(), Outcome::running);
    const std::vector<StopReason> reasons = events_.at(position_);
    for (std::size_t i = 0; i < outcomes.size(); ++i) outcomes[i] = outcome_of(reasons[i]);
    settle(outcomes);
  }

  std::vector<bool> run() {
    for (int i = 0; i < kMostSteps && position_.rows() > 0; ++i) advance();
    return safe_;
  }

 private:
  enum class Outcome { running, safe, unsafe };

  static Outcome outcome_of(StopReason reason) {
    if (reason == StopReason::time_out) return Outcome::running;
    return reason == StopReason::reached_goal ? Outcome::safe : Outcome::unsafe;
  }

  // A trial step of every motion: where it ends, f there, and the local error in units of the tolerance.
  struct Trial {
    Points position;
    Points velocity;
    Vector error;
  };

  Trial try_step() const {
    const auto h = step_.asDiagonal();
    const Points& k1 = velocity_;
    const Points k2 = field_.quick_value(position_ + h * (0.5 * k1));
    const Points k3 = field_.quick_value(position_ + h * (0.75 * k2));
    Trial trial;
    trial.position = position_ + h * (2.0 / 9.0 * k1 + 1.0 / 3.0 * k2 + 4.0 / 9.0 * k3);
    trial.velocity = field_.quick_value(trial.position);
    const Points difference =
        -5.0 / 72.0 * k1 + 1.0 / 12.0 * k2 + 1.0 / 9.0 * k3 - 1.0 / 8.0 * trial.velocity;
    trial.error = (h * difference).rowwise().norm() / options_.tolerance;
    return trial;
  }

  void advance() {
    const Trial trial = try_step();
    std::vector<Outcome> outcomes(start_index_.size(), Outcome::running);
    std::vector<Eigen::Index> accepted;
    for (Eigen::Index i = 0; i < trial.error.size(); ++i) {
      // Not a number, or a step that cannot be made short enough: nothing good can be said of this motion.
      if (!std::isfinite(trial.error[i]) || !(step_[i] > kShortestStep)) {
        outcomes[static_cast<std::size_t>(i)] = Outcome::unsafe;
      } else if (trial.error[i] <= 1.0) {
        accepted.push_back(i);
      }
    }
    look_along(trial, accepted, outcomes);
    for (const Eigen::Index i : accepted) {
      position_.row(i) = trial.position.row(i);
      velocity_.row(i) = trial.velocity.row(i);
      time_[i] += step_[i];
      Outcome& outcome = outcomes[static_cast<std::size_t>(i)];
      if (outcome == Outcome::running && time_[i] >= options_.duration) outcome = Outcome::unsafe;
    }
    for (Eigen::Index i = 0; i < step_.size(); ++i) step_[i] = next_step(step_[i], trial.error[i]);
    settle(outcomes);
  }

  // The usual controller of a third-order step whose error estimate is of the third power.
  double next_step(double step, double error) const {
    const double factor = 0.9 / std::cbrt(std::max(error, 1e-6));
    return std::min(options_.step, step * std::clamp(factor, 0.2, 5.0));
  }

  Eigen::Index looks(const Trial& trial, Eigen::Index i) const {
    const double fastest = std::max(velocity_.row(i).norm(), trial.velocity.row(i).norm());
    const double length = std::max(step_[i] * fastest, (trial.position.row(i) - position_.row(i)).norm());
    const double wanted = std::ceil(length / look_spacing);
    return static_cast<Eigen::Index>(std::clamp(wanted, 1.0, static_cast<double>(most_looks)));
  }

  // The cubic with the step's ends and velocities (Hermite), at the fraction s of the step.
  void place_between(const Trial& trial, Eigen::Index i, double s,
                     Eigen::Ref<Eigen::RowVectorXd> point) const {
    const double r = 1.0 - s;
    point = r * r * (1.0 + 2.0 * s) * position_.row(i) + s * s * (3.0 - 2.0 * s) * trial.position.row(i) +
            step_[i] * s * r * (r * velocity_.row(i) - s * trial.velocity.row(i));
  }

  // The first event along each accepted step decides its motion.
  void look_along(const Trial& trial, const std::vector<Eigen::Index>& accepted,
                  std::vector<Outcome>& outcomes) {
    std::vector<Eigen::Index> counts;
    for (const Eigen::Index i : accepted) counts.push_back(looks(trial, i));
    Points seen(std::accumulate(counts.begin(), counts.end(), Eigen::Index{0}), position_.cols());
    Eigen::Index row = 0;
    for (std::size_t a = 0; a < accepted.size(); ++a) {
      for (Eigen::Index j = 1; j <= counts[a]; ++j) {
        const double fraction = static_cast<double>(j) / static_cast<double>(counts[a]);
        place_between(trial, accepted[a], fraction, seen.row(row++));
      }
    }
    const std::vector<StopReason> reasons = events_.at(seen, in_unsafe(trial, accepted, counts, seen));
    std::size_t at = 0;
    for (std::size_t a = 0; a < accepted.size(); ++a) {
      Outcome& outcome = outcomes[static_cast<std::size_t>(accepted[a])];
      for (Eigen::Index j = 0; j < counts[a]; ++j, ++at) {
        if (outcome == Outcome::running) outcome = outcome_of(reasons[at]);
      }
    }
  }

  // Which of the places seen along the accepted steps, `counts` of each, lie in the unsafe set. A level that is
  // 1-Lipschitz is computed only where the motion may have come as far as it was at the last one, first at the ends of
  // these steps, then at the places that neither end of the step answers for.
  std::vector<bool> in_unsafe(const Trial& trial, const std::vector<Eigen::Index>& accepted,
                              const std::vector<Eigen::Index>& counts, const Points& seen) {
    const auto distance = [&](Eigen::Index row, const Points& from, Eigen::Index i) {
      return (seen.row(row) - from.row(i)).norm();
    };
    std::vector<Eigen::Index> motions, first, ends;  // of steps that may meet the set; rows of `seen`
    Eigen::Index row = 0;
    for (std::size_t a = 0; a < accepted.size(); row += counts[a++]) {
      const Eigen::Index i = accepted[a];
      double farthest = 0.0;
      for (Eigen::Index j = row; j < row + counts[a]; ++j)
        farthest = std::max(farthest, distance(j, position_, i));
      if (farthest < clear_[i]) {
        clear_[i] -= distance(row + counts[a] - 1, position_, i);
        continue;
      }
      motions.push_back(i);
      first.push_back(row);
      ends.push_back(row + counts[a] - 1);
    }
    std::vector<bool> unsafe(static_cast<std::size_t>(seen.rows()), false);
    const double share = unsafe_.is_lipschitz() ? kSureShare : 0.0;
    std::vector<Eigen::Index> between;
    const Vector at_end = ends.empty() ? Vector() : unsafe_.level(seen(ends, Eigen::all));
    for (std::size_t k = 0; k < ends.size(); ++k) {
      const Eigen::Index i = motions[k];
      const double level = at_end[static_cast<Eigen::Index>(k)];
      unsafe[static_cast<std::size_t>(ends[k])] = level <= 0.0;
      for (Eigen::Index j = first[k]; j < ends[k]; ++j) {
        if (distance(j, position_, i) < clear_[i] || distance(j, trial.position, i) < share * level) continue;
        between.push_back(j);
      }
      clear_[i] = share * level;
    }
    if (between.empty()) return unsafe;
    const Vector level = unsafe_.level(seen(between, Eigen::all));
    for (std::size_t k = 0; k < between.size(); ++k)
      unsafe[static_cast<std::size_t>(between[k])] = level[static_cast<Eigen::Index>(k)] <= 0.0;
    return unsafe;
  }

  // Writes down what is decided and keeps what still runs.
  void settle(const std::vector<Outcome>& outcomes) {
    std::vector<std::size_t> running;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      if (outcomes[i] == Outcome::running) running.push_back(i);
      safe_[start_index_[i]] = outcomes[i] == Outcome::safe;
    }
    if (running.size() == outcomes.size()) return;
    for (std::size_t to = 0; to < running.size(); ++to) {
      const auto from = static_cast<Eigen::Index>(running[to]);
      const auto row = static_cast<Eigen::Index>(to);
      start_index_[to] = start_index_[running[to]];
      position_.row(row) = position_.row(from);
      velocity_.row(row) = velocity_.row(from);
      time_[row] = time_[from];
      step_[row] = step_[from];
      clear_[row] = clear_[from];
    }
    const auto left = static_cast<Eigen::Index>(running.size());
    start_index_.resize(running.size());
    position_.conservativeResize(left, Eigen::NoChange);
    velocity_.conservativeResize(left, Eigen::NoChange);
    time_.conservativeResize(left);
    step_.conservativeResize(left);
    clear_.conservativeResize(left);
  }

  const StateFunction& field_;
  const Region& unsafe_;
  RolloutEvents events_;
  BatchRolloutOptions options_;
  std::vector<bool> safe_;                // [starts]
  std::vector<std::size_t> start_index_;  // [running], as all below
  Points position_;
  Points velocity_;  // f(position)
  Vector time_;
  Vector step_;
  Vector clear_;  // the unsafe set is farther away than this
};

}  // namespace

std::vector<bool> rollout_is_safe(const StateFunction& f, const SafetyProblem& problem, const Points& starts,
                                  const BatchRolloutOptions& options) {
  check(starts.cols() == problem.dimension(), "rollout_is_safe: found starts of dimension {}, expected {}",
        starts.cols(), problem.dimension());
  check(starts.allFinite(), "rollout_is_safe: found a start that is not finite, expected numbers");
  check(
      options.step > 0.0 && options.tolerance > 0.0 && options.duration > 0.0 && options.goal_radius > 0.0,
      "rollout_is_safe: found step = {}, tolerance = {}, duration = {}, goal_radius = {}, expected each > 0",
      options.step, options.tolerance, options.duration, options.goal_radius);
  if (starts.rows() > 0) check_outputs(f, starts.row(0), starts.cols(), "rollout_is_safe");
  const Eigen::Index chunks = (starts.rows() + kChunk - 1) / kChunk;
  std::vector<std::vector<bool>> safe(static_cast<std::size_t>(chunks));
  // One parallel loop over chunks: within a chunk the batches become too small to share.
  parallel_for(chunks, [&](Eigen::Index c, int) {
    const Eigen::Index first = c * kChunk;
    const Points part = starts.middleRows(first, std::min(kChunk, starts.rows() - first));
    safe[static_cast<std::size_t>(c)] = BatchRollout(f, problem, part, options).run();
  });
  std::vector<bool> all;
  for (const std::vector<bool>& part : safe) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace s2nnds
