// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/fidelity.h"

#include <algorithm>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/dynamic_time_warping.h"
#include "s2nnds/data/survey.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kPlaces = 200;  // of a path
// Of the limit, at most, where demonstrations lie farther apart than it: two that go different ways, or start in
// different places, would otherwise allow anything.
constexpr double kMostOfLimit = 1.5;

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

// Of the path [M, n] from what is shown; `limit` stays 0.
Deviation deviation(const Points& path, const Shown& shown) {
  Points distance(path.rows(), kPlaces);
  for (Eigen::Index j = 0; j < kPlaces; ++j) {
    if (shown.counts[j]) {
      distance.col(j) = (path.rowwise() - shown.place.row(j)).rowwise().norm();
    } else {
      distance.col(j).setZero();
    }
  }
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

std::vector<Shown> shown_paths(const std::vector<Demonstration>& demonstrations, const SafetyProblem& problem,
                               double margin) {
  std::vector<Shown> shown;
  for (const Demonstration& each : demonstrations) shown.push_back(shown_path(each, problem, margin));
  return shown;
}

// `limit`, or the distance to the nearest other demonstration, up to kMostOfLimit.
double limit_of(const std::vector<Shown>& shown, std::size_t k, double limit) {
  if (shown.size() == 1) return limit;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t other = 0; other < shown.size(); ++other)
    if (other != k) nearest = std::min(nearest, deviation(shown[other].place, shown[k]).mean);
  return std::clamp(nearest, limit, kMostOfLimit * limit);
}

}  // namespace

std::vector<Deviation> deviations(const StateFunction& f, const SafetyProblem& problem,
                                  const std::vector<Demonstration>& demonstrations, double limit,
                                  double margin, const RolloutOptions& options) {
  const std::vector<Shown> shown = shown_paths(demonstrations, problem, margin);
  std::vector<Deviation> all;
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const Rollout motion = roll_out(f, problem, demonstrations[k].position.row(0).transpose(), options);
    Deviation found = deviation(along_path(motion.position, kPlaces), shown[k]);
    found.limit = limit_of(shown, k, limit);
    all.push_back(found);
  }
  return all;
}

std::vector<Deviation> start_deviations(const StateFunction& f, const SafetyProblem& problem,
                                        const std::vector<Demonstration>& demonstrations,
                                        const Points& starts, double limit, double margin,
                                        const RolloutOptions& options) {
  check(!demonstrations.empty(), "fidelity: found no demonstrations, expected at least one");
  const std::vector<Shown> shown = shown_paths(demonstrations, problem, margin);
  std::vector<double> limits;
  for (std::size_t k = 0; k < shown.size(); ++k) limits.push_back(limit_of(shown, k, limit));
  std::vector<Deviation> all;
  for (Eigen::Index i = 0; i < starts.rows(); ++i) {
    const Points path =
        along_path(roll_out(f, problem, starts.row(i).transpose(), options).position, kPlaces);
    Deviation nearest{.mean = std::numeric_limits<double>::infinity()};
    for (std::size_t k = 0; k < shown.size(); ++k) {
      Deviation found = deviation(path, shown[k]);
      found.limit = limits[k];
      if (found.mean < nearest.mean) nearest = found;
    }
    all.push_back(nearest);
  }
  return all;
}

double worst_share(const std::vector<Deviation>& deviations) {
  double worst = 0.0;
  for (const Deviation& each : deviations) worst = std::max(worst, each.mean / each.limit);
  return worst;
}

}  // namespace s2nnds
