// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/robustness.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "s2nnds/core/parallel.h"
#include "s2nnds/core/random.h"
#include "s2nnds/evaluation/safe_area.h"
#include "s2nnds/problem/boundary_points.h"

namespace s2nnds {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
constexpr int kSobolStarts = 400;  // in more than three dimensions, where a grid has too many

struct Start {
  Vector position;
  Vector push = {};  // the displacement in mid-motion, empty: none
};

struct Motion {
  Points path;
  StopReason stop = StopReason::time_out;
  double duration = 0.0;
  std::vector<Vector> placed;  // where it was put: its start, and where a displacement ended

  bool is_safe() const { return stop == StopReason::reached_goal || stop == StopReason::time_out; }
};

bool is_free(const SafetyProblem& problem, const Vector& x) {
  return problem.workspace.contains(x) && problem.unsafe->level(x.transpose())[0] > 0.0;
}

Motion follow(const StateFunction& f, const SafetyProblem& problem, const Vector& start,
              const RolloutOptions& options) {
  const Rollout rollout = roll_out(f, problem, start, options);
  return {rollout.position, rollout.stop, rollout.time[rollout.time.size() - 1], {start}};
}

Motion follow_pushed(const StateFunction& f, const SafetyProblem& problem, const Start& start,
                     const RolloutOptions& options) {
  const Motion whole = follow(f, problem, start.position, options);
  if (start.push.size() == 0 || whole.stop != StopReason::reached_goal) return whole;
  RolloutOptions half = options;
  half.duration = 0.5 * whole.duration;
  Motion motion = follow(f, problem, start.position, half);
  const Vector moved = motion.path.row(motion.path.rows() - 1).transpose() + start.push;
  motion.placed.push_back(moved);
  if (!is_free(problem, moved)) {
    motion.stop = problem.workspace.contains(moved) ? StopReason::entered_unsafe : StopReason::left_workspace;
    return motion;
  }
  const Motion rest = follow(f, problem, moved, options);
  Points path(motion.path.rows() + rest.path.rows(), motion.path.cols());
  path << motion.path, rest.path;
  return {path, rest.stop, motion.duration + rest.duration, motion.placed};
}

double distance_of_point(const Eigen::RowVectorXd& point, const Eigen::Ref<const Points>& boundary) {
  return std::sqrt((boundary.rowwise() - point).rowwise().squaredNorm().minCoeff());
}

// Points of the obstacle's boundary, of which some tell what part of a path comes near, and all how near.
class Obstacle {
 public:
  explicit Obstacle(Points boundary) : boundary_(std::move(boundary)) {
    for (Eigen::Index i = 0; i < boundary_.rows(); ++i)
      gap_ = std::max(gap_, distance_of_point(boundary_.row(i), few()));
  }
  bool is_empty() const { return boundary_.rows() == 0; }

  double distance(const Points& path) const {
    Vector roughly(path.rows());
    for (Eigen::Index i = 0; i < path.rows(); ++i) roughly[i] = distance_of_point(path.row(i), few());
    const double near = roughly.minCoeff() + gap_;
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < path.rows(); ++i) {
      if (roughly[i] <= near) least = std::min(least, distance_of_point(path.row(i), boundary_));
    }
    return least;
  }

 private:
  Eigen::Ref<const Points> few() const {
    return boundary_.topRows(std::min<Eigen::Index>(1000, boundary_.rows()));
  }

  Points boundary_;
  double gap_ = 0.0;  // the farthest of all from the few
};

bool is_covered(const Motion& motion, const StateFunction& B) {
  return std::all_of(motion.placed.begin(), motion.placed.end(),
                     [&](const Vector& x) { return B.value(x.transpose())(0, 0) <= 0.0; });
}

Vector normal(Eigen::Index n, RandomStream& random) {
  Vector v(n);
  for (Eigen::Index k = 0; k < n; ++k) v[k] = random.normal();
  return v;
}

std::vector<Start> grid_starts(const SafetyProblem& problem, int cells) {
  const Points x = evaluation_points(problem.workspace, cells);
  std::vector<Start> starts;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    if (is_free(problem, x.row(i).transpose())) starts.push_back({x.row(i).transpose()});
  }
  return starts;
}

MotionOutcomes outcomes(const std::string& starts, const std::vector<Motion>& motions,
                        const std::optional<StateFunction>& B, const Obstacle& obstacle) {
  MotionOutcomes found{.starts = starts,
                       .motions = static_cast<std::int64_t>(motions.size()),
                       .covered_converged = kNotMeasured,
                       .closest = kNotMeasured,
                       .mean_closest = kNotMeasured,
                       .time_to_goal = kNotMeasured};
  std::vector<double> times, distances(motions.size(), kNotMeasured);
  if (!obstacle.is_empty()) {
    parallel_for(static_cast<std::ptrdiff_t>(motions.size()), [&](std::ptrdiff_t i, int) {
      if (motions[i].is_safe()) distances[i] = obstacle.distance(motions[i].path);
    });
  }
  if (motions.empty()) return found;
  std::int64_t converged = 0, safe = 0, covered_converged = 0;
  for (const Motion& motion : motions) {
    const bool arrived = motion.stop == StopReason::reached_goal;
    const bool covered = B && is_covered(motion, *B);
    converged += arrived;
    safe += motion.is_safe();
    found.covered += covered;
    covered_converged += covered && arrived;
    if (arrived) times.push_back(motion.duration);
  }
  const auto count = static_cast<double>(motions.size());
  found.converged = static_cast<double>(converged) / count;
  found.safe = static_cast<double>(safe) / count;
  if (found.covered > 0)
    found.covered_converged = static_cast<double>(covered_converged) / static_cast<double>(found.covered);
  std::erase_if(distances, [](double d) { return std::isnan(d); });
  if (!distances.empty()) {
    found.closest = *std::min_element(distances.begin(), distances.end());
    found.mean_closest =
        std::accumulate(distances.begin(), distances.end(), 0.0) / static_cast<double>(distances.size());
  }
  std::sort(times.begin(), times.end());
  if (!times.empty()) found.time_to_goal = times[times.size() / 2];
  return found;
}

}  // namespace

std::vector<MotionOutcomes> measure_robustness(const StateFunction& f, const std::optional<StateFunction>& B,
                                               const SafetyProblem& problem,
                                               const std::vector<Demonstration>& demonstrations,
                                               std::uint64_t seed, const RobustnessOptions& options) {
  const Eigen::Index n = problem.dimension();
  RandomStream boundary_random(seed, "robustness/boundary");
  const Obstacle obstacle(boundary_points(problem.unsafe, problem.workspace,
                                          (n == 2 ? 1 : 8) * options.boundary_samples, boundary_random)
                              .point);
  std::vector<Start> perturbed, pushed;
  RandomStream beside(seed, "robustness/perturbed"), pushing(seed, "robustness/pushed");
  for (const Demonstration& demonstration : demonstrations) {
    const Vector start = demonstration.position.row(0).transpose();
    for (int k = 0; k < options.repetitions; ++k) {
      Vector moved = start + options.perturbation * normal(n, beside);
      for (int attempt = 0; attempt < 100 && !is_free(problem, moved); ++attempt)
        moved = start + options.perturbation * normal(n, beside);
      perturbed.push_back({is_free(problem, moved) ? moved : start});
      pushed.push_back({start, options.push * normal(n, pushing).normalized()});
    }
  }
  std::vector<MotionOutcomes> found;
  const auto measure = [&](const std::string& name, const std::vector<Start>& starts) {
    std::vector<Motion> motions(starts.size());
    parallel_for(static_cast<std::ptrdiff_t>(starts.size()), [&](std::ptrdiff_t i, int) {
      motions[i] = follow_pushed(f, problem, starts[i], options.rollout);
    });
    found.push_back(outcomes(name, motions, B, obstacle));
  };
  measure("grid", grid_starts(problem, n == 2   ? options.grid
                                       : n == 3 ? std::min(options.grid, 8)
                                                : kSobolStarts));
  if (perturbed.empty()) return found;
  measure("perturbed", perturbed);
  measure("pushed", pushed);
  return found;
}

}  // namespace s2nnds
