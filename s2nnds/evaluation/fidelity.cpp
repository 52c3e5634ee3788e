// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/fidelity.h"

#include <algorithm>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/dynamic_time_warping.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/data/survey.h"
#include "s2nnds/problem/phase_targets.h"
#include "s2nnds/problem/start_paths.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kPlaces = 200;  // of a path
// Of the limit, at most, where demonstrations lie farther apart than it: two that go different ways, or start
// in different places, would otherwise allow anything.
constexpr double kMostOfLimit = 1.5;
// Share of the limit beyond which a motion is corrected.
constexpr double kStrays = 0.8;
constexpr double kTouches = 1e-3;  // of the unsafe set's level, where a motion stops at it
// Where one demonstration strays, so do others once that one alone is corrected, and the other way round in the next
// round. So all are shown that keep off the unsafe set, and those that stray so many times as often.
constexpr int kMoreOfStraying = 3;
constexpr Eigen::Index kCorrected = 5;  // one of so many places is corrected
constexpr Eigen::Index kEvery = 3;      // the same along a motion with a phase
// Towards the path that should be taken, per distance to it, 1 / normalised time.
constexpr double kGain = 1.0;
// Corrections are at least so fast: motions start slowly, and errors of f as large as its velocity turn them
// aside.
constexpr double kLeastSpeed = 0.05;

// Places of a demonstration, and which of them count.
struct Shown {
  Points place;              // [kPlaces, n]
  std::vector<bool> counts;  // [kPlaces]
};

Shown shown_path(const Demonstration& demonstration, const SafetyProblem& problem, double margin) {
  Shown shown{along_path(demonstration.position, kPlaces), std::vector<bool>(kPlaces, true)};
  for (Eigen::Index j = 0; j < kPlaces; ++j) {
    const Vector x = shown.place.row(j), near = Vector::Constant(x.size(), margin);
    shown.counts[j] = problem.unsafe->classify({x - near, x + near}) == Location::outside;
  }
  return shown;
}

// Distances, over the first `judged` coordinates, of the places of a path [M, n] from those that are shown; 0 where they
// do not count.
Points distances(const Points& path, const Shown& shown, Eigen::Index judged) {
  const Points place = shown.place.leftCols(judged).transpose();  // by coordinates, which is faster
  Points distance = Points::Zero(path.rows(), kPlaces);
  for (Eigen::Index i = 0; i < path.rows(); ++i) {
    for (Eigen::Index d = 0; d < judged; ++d)
      distance.row(i).array() += (place.row(d).array() - path(i, d)).square();
  }
  distance = distance.cwiseSqrt();
  for (Eigen::Index j = 0; j < kPlaces; ++j) {
    if (!shown.counts[j]) distance.col(j).setZero();
  }
  return distance;
}

// Of the path [M, n] from what is shown; `limit` stays 0.
Deviation deviation(const Points& path, const Shown& shown, Eigen::Index judged) {
  const Points distance = distances(path, shown, judged);
  Deviation found;
  double pairs = 0.0;
  for (const auto& [i, j] : warp(distance).pairs) {
    if (!shown.counts[j]) continue;
    found.mean += distance(i, j);
    found.largest = std::max(found.largest, distance(i, j));
    pairs += 1.0;
  }
  found.mean /= std::max(pairs, 1.0);
  return found;
}

// The paths [kPlaces, n] of the motions from `starts`.
std::vector<Points> paths_from(const Points& starts, const StateFunction& f, const SafetyProblem& problem,
                               const RolloutOptions& options) {
  std::vector<Points> paths(static_cast<std::size_t>(starts.rows()));
  parallel_for(starts.rows(), [&](Eigen::Index i, int) {
    paths[static_cast<std::size_t>(i)] =
        along_path(roll_out(f, problem, starts.row(i).transpose(), options).position, kPlaces);
  });
  return paths;
}

Points first_points(const std::vector<Demonstration>& demonstrations) {
  Points starts(std::ssize(demonstrations), demonstrations.empty() ? 0 : demonstrations.front().dimension());
  for (Eigen::Index k = 0; k < starts.rows(); ++k)
    starts.row(k) = demonstrations[static_cast<std::size_t>(k)].position.row(0);
  return starts;
}

std::vector<Shown> shown_paths(const std::vector<Demonstration>& demonstrations, const SafetyProblem& problem,
                               double margin) {
  std::vector<Shown> shown;
  for (const Demonstration& each : demonstrations) shown.push_back(shown_path(each, problem, margin));
  return shown;
}

// `limit`, or the distance to the nearest other demonstration, up to kMostOfLimit.
double limit_of(const std::vector<Shown>& shown, std::size_t k, double limit, Eigen::Index judged) {
  if (shown.size() == 1) return limit;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t other = 0; other < shown.size(); ++other)
    if (other != k) nearest = std::min(nearest, deviation(shown[other].place, shown[k], judged).mean);
  return std::clamp(nearest, limit, kMostOfLimit * limit);
}

// What is judged by: the demonstrations and their limits.
struct Reference {
  const SafetyProblem& problem;
  const std::vector<Demonstration>& demonstrations;
  std::vector<Shown> shown;
  std::vector<double> limits;

  Reference(const SafetyProblem& sets, const std::vector<Demonstration>& motions, double limit, double margin)
      : problem(sets),
        demonstrations(motions),
        shown(shown_paths(motions, sets, margin)),
        limits(shown.size()) {
    parallel_for(std::ssize(shown), [&](std::ptrdiff_t at, int) {
      const auto k = static_cast<std::size_t>(at);
      limits[k] = limit_of(shown, k, limit, problem.places());
    });
  }

  Deviation from(std::size_t k, const Points& path) const {
    Deviation found = deviation(path, shown[k], problem.places());
    found.limit = limits[k];
    return found;
  }

  // Whether the path ends at the unsafe set, through which the demonstration leads: only conditions on B can
  // turn it aside.
  bool leads_into_unsafe(std::size_t k, const Points& path) const {
    return problem.unsafe->level(path.bottomRows(1))[0] <= kTouches && passes_through(k);
  }
  bool passes_through(std::size_t k) const { return problem.unsafe->level(shown[k].place).minCoeff() <= 0.0; }

  // What is shown of demonstration k, displaced so that it starts at `start`.
  Shown displaced(std::size_t k, const Eigen::RowVectorXd& start) const {
    Shown led = shown[k];
    const Vector factor = displacement_along(led.place);
    led.place += factor * (start - led.place.row(0));
    return led;
  }

  // Of the motions from the demonstrations' first points.
  std::vector<Deviation> from_shown(const std::vector<Points>& paths) const {
    std::vector<Deviation> all(paths.size());
    parallel_for(std::ssize(paths), [&](std::ptrdiff_t at, int) {
      const auto k = static_cast<std::size_t>(at);
      all[k] = from(k, paths[k]);
    });
    return all;
  }
  // Of the motions from starts that were not shown.
  std::vector<Deviation> from_starts(const std::vector<Points>& paths, const Points& starts) const {
    std::vector<Deviation> all(paths.size());
    parallel_for(std::ssize(paths), [&](std::ptrdiff_t at, int) {
      const auto i = static_cast<std::size_t>(at);
      all[i] = from_best(paths[i], starts.row(at));
    });
    return all;
  }

  // Of the motion from a start that was not shown.
  Deviation from_best(const Points& path, const Eigen::RowVectorXd& start) const {
    Deviation best{.mean = std::numeric_limits<double>::infinity(), .limit = limits.front()};
    for (std::size_t k = 0; k < shown.size(); ++k) {
      Deviation found = from(k, path);
      found.limit += (start - shown[k].place.row(0)).norm() / 3.0;
      if (found.mean / found.limit < best.mean / best.limit) best = found;
    }
    const Points led = displaced(nearest_start(demonstrations, start.transpose()), start).place;
    if (problem.unsafe->level(led).minCoeff() <= 0.0) best.limit = std::numeric_limits<double>::infinity();
    return best;
  }
};

// The velocity of the demonstration at each of its places evenly spaced along it: [kPlaces, n].
Points velocities_along(const Demonstration& demonstration) {
  const Points& x = demonstration.position;
  const Vector length = arc_lengths(x);
  Points velocity(kPlaces, x.cols());
  Eigen::Index i = 0;
  for (Eigen::Index j = 0; j < kPlaces; ++j) {
    const double along = length[x.rows() - 1] * static_cast<double>(j) / static_cast<double>(kPlaces - 1);
    while (i + 1 < x.rows() && length[i] < along) ++i;
    velocity.row(j) = demonstration.velocity.row(i);
  }
  return velocity;
}

class CorrectionList {
 public:
  // Of a motion's path that should be as `led`, with velocities [kPlaces, n] there.
  void add(const Points& path, const Shown& led, const Points& velocity, bool has_phase) {
    if (has_phase) {
      add_by_phase(path, led, velocity);
      return;
    }
    const Points distance = distances(path, led, path.cols());
    for (const auto& [i, j] : warp(distance).pairs) {
      if ((i + j) % kCorrected != 0 || !led.counts[j]) continue;
      add(path.row(i), velocity.row(j) + kGain * (led.place.row(j) - path.row(i)));
      add(led.place.row(j), velocity.row(j));
    }
  }

  VelocityTargets list(Eigen::Index dimension) const {
    const auto count = static_cast<Eigen::Index>(position_.size());
    VelocityTargets all{Points(count, dimension), Points(count, dimension)};
    for (Eigen::Index i = 0; i < count; ++i) {
      all.position.row(i) = position_[static_cast<std::size_t>(i)];
      all.velocity.row(i) = velocity_[static_cast<std::size_t>(i)];
    }
    return all;
  }

 private:
  // The phase says where the motion should be, and runs down as it does there: it is not led back itself.
  void add_by_phase(const Points& path, const Shown& led, const Points& velocity) {
    const Eigen::Index last = path.cols() - 1;
    Eigen::Index j = 0;
    for (Eigen::Index i = 0; i < path.rows(); i += kEvery) {
      while (j + 1 < kPlaces && led.place(j, last) > path(i, last)) ++j;
      if (!led.counts[j]) continue;
      Eigen::RowVectorXd way = led.place.row(j) - path.row(i);
      way[last] = 0.0;
      add(path.row(i), velocity.row(j) + phase_gain * way);
      add(led.place.row(j), velocity.row(j));
    }
  }

  void add(const Eigen::RowVectorXd& x, Eigen::RowVectorXd v) {
    const double speed = v.norm();
    if (speed > 0.0 && speed < kLeastSpeed && x.norm() > kLeastSpeed) v *= kLeastSpeed / speed;
    position_.push_back(x);
    velocity_.push_back(std::move(v));
  }

  std::vector<Eigen::RowVectorXd> position_, velocity_;
};

}  // namespace

std::vector<Deviation> deviations(const StateFunction& f, const SafetyProblem& problem,
                                  const std::vector<Demonstration>& demonstrations, double limit,
                                  double margin, const RolloutOptions& options) {
  const Reference reference(problem, demonstrations, limit, margin);
  return reference.from_shown(paths_from(first_points(demonstrations), f, problem, options));
}

std::vector<Deviation> start_deviations(const StateFunction& f, const SafetyProblem& problem,
                                        const std::vector<Demonstration>& demonstrations,
                                        const Points& starts, double limit, double margin,
                                        const RolloutOptions& options) {
  check(!demonstrations.empty(), "fidelity: found no demonstrations, expected at least one");
  const Reference reference(problem, demonstrations, limit, margin);
  return reference.from_starts(paths_from(starts, f, problem, options), starts);
}

VelocityTargets corrections_of(const StateFunction& f, const SafetyProblem& problem,
                               const std::vector<Demonstration>& demonstrations, const Points& starts,
                               double limit, double margin, const RolloutOptions& options) {
  check(!demonstrations.empty(), "fidelity: found no demonstrations, expected at least one");
  const Reference reference(problem, demonstrations, limit, margin);
  CorrectionList list;
  const auto strays = [](const Deviation& found) { return !(found.mean <= kStrays * found.limit); };
  const std::vector<Points> shown = paths_from(first_points(demonstrations), f, problem, options);
  const std::vector<Deviation> found_shown = reference.from_shown(shown);
  std::vector<int> times;  // that each demonstration is shown
  bool one_strays = false, all_follow = true;
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const Deviation& found = found_shown[k];
    const bool counts = !reference.leads_into_unsafe(k, shown[k]);
    if (counts && strays(found)) one_strays = true;
    if (counts && !found.follows()) all_follow = false;
    times.push_back(!counts ? 0 : strays(found) ? kMoreOfStraying : reference.passes_through(k) ? 0 : 1);
  }
  for (std::size_t k = 0; k < shown.size() && one_strays; ++k)
    for (int i = 0; i < times[k]; ++i)
      list.add(shown[k], reference.shown[k], velocities_along(demonstrations[k]), problem.has_phase());
  // Starts that were not shown are led as demonstrations go, so these come first.
  if (!all_follow) return list.list(problem.dimension());
  const std::vector<Points> paths = paths_from(starts, f, problem, options);
  const std::vector<Deviation> found = reference.from_starts(paths, starts);
  for (Eigen::Index i = 0; i < starts.rows(); ++i) {
    const Points& path = paths[static_cast<std::size_t>(i)];
    if (!strays(found[static_cast<std::size_t>(i)])) continue;
    const std::size_t k = nearest_start(demonstrations, starts.row(i).transpose());
    list.add(path, reference.displaced(k, starts.row(i)), velocities_along(demonstrations[k]),
             problem.has_phase());
  }
  return list.list(problem.dimension());
}

double worst_share(const std::vector<Deviation>& deviations) {
  double worst = 0.0;
  for (const Deviation& each : deviations) worst = std::max(worst, each.mean / each.limit);
  return worst;
}

}  // namespace s2nnds
