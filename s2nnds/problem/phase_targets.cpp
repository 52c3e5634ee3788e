// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/phase_targets.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/data/survey.h"

namespace s2nnds {
namespace {

constexpr double kFastest = 0.7;       // towards the path
constexpr double kShown = 0.05;        // from the path: nearer, the demonstrations show the way
constexpr double kAround = 0.2;        // standard deviation of the places that are drawn around the path
constexpr double kEnd = 0.1;           // of the phase: from here on what is shown fades
constexpr double kSlowest = 0.1;       // of the phase
constexpr Eigen::Index kBetween = 20;  // places between a sample and the path that are looked at
constexpr std::int64_t kDraws = 20;    // a sample that is wanted
constexpr Eigen::Index kPassed = 200;  // of a demonstration

// The first sample at which the phase, which falls, is at most `s`; the last one where there is none.
Eigen::Index sample_at(const Demonstration& d, double s) {
  const auto phase = d.position.rightCols(1);
  Eigen::Index i = 0;
  while (i + 1 < d.samples() && phase(i, 0) > s) ++i;
  return i;
}

// Whether the unsafe set lies between two places.
bool is_blocked(const SafetyProblem& problem, const Eigen::RowVectorXd& from, const Eigen::RowVectorXd& to,
                double s) {
  Points between(kBetween + 1, from.size() + 1);
  for (Eigen::Index j = 0; j <= kBetween; ++j)
    between.row(j) << from + static_cast<double>(j) / static_cast<double>(kBetween) * (to - from), s;
  return problem.unsafe->level(between).minCoeff() <= 0.0;
}

// What is shown counts less near the end, where f must vanish: recordings may end under way.
double share_at(double s) { return std::clamp(s / kEnd, 0.0, 1.0); }

double rate_at(double s, double shown) { return s < 0.0 ? -s : std::min(shown, -std::min(kSlowest, s)); }

}  // namespace

VelocityTargets phase_targets(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                              std::int64_t count, RandomStream& random) {
  check(problem.has_phase() && !demonstrations.empty(),
        "phase targets: found {} demonstrations{}, expected some of states with a phase",
        demonstrations.size(), problem.has_phase() ? "" : " without a phase");
  const Eigen::Index places = problem.places();
  const Box& all = problem.workspace;
  VelocityTargets targets{Points(count, places + 1), Points(count, places + 1)};
  Eigen::Index row = 0;
  for (std::int64_t draw = 0; draw < kDraws * count && row < count; ++draw) {
    const Demonstration& d = demonstrations[random.below(demonstrations.size())];
    const double s = random.uniform(all.lower[places], all.upper[places]);
    const Eigen::Index i = sample_at(d, s);
    const Eigen::RowVectorXd path = d.position.row(i).head(places);
    const bool anywhere = random.below(3) > 0;
    Eigen::RowVectorXd x(places);
    for (Eigen::Index k = 0; k < places; ++k)
      x[k] = anywhere ? random.uniform(all.lower[k], all.upper[k]) : path[k] + kAround * random.normal();
    const double distance = (path - x).norm();
    if (!(distance >= kShown) || is_blocked(problem, x, path, s)) continue;
    targets.position.row(row) << x, s;
    const double share = share_at(s);
    targets.velocity.row(row) << share * d.velocity.row(i).head(places) +
                                     std::min(phase_gain, kFastest / distance) * (path - x),
        rate_at(s, share * d.velocity(i, places));
    ++row;
  }
  targets.position.conservativeResize(row, Eigen::NoChange);
  targets.velocity.conservativeResize(row, Eigen::NoChange);
  return targets;
}

Points phase_path(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations) {
  check(problem.has_phase(), "phase path: found a problem without a phase, expected one with");
  Points path(0, problem.dimension());
  for (const Demonstration& each : demonstrations) {
    const Points places = along_path(each.position, kPassed);
    if (problem.unsafe->level(places).minCoeff() <= 0.0) continue;
    path.conservativeResize(path.rows() + kPassed, Eigen::NoChange);
    path.bottomRows(kPassed) = places;
  }
  return path;
}

}  // namespace s2nnds
