// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/band_falsifier.h"

#include <algorithm>
#include <limits>

#include "s2nnds/networks/evaluator.h"
#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/training/climb.h"

namespace s2nnds {
namespace {

constexpr int kMoves = 6, kMovesOfAStep = 2;  // of Newton's method: at first, after each step of a climb
constexpr double kLongestMove = 0.5;          // as a share of the workspace's largest half width

Points spread_points(const Box& workspace, std::int64_t count, RandomStream& random) {
  Points x = uniform_points(workspace, count, random);
  for (Eigen::Index i = 1; i < x.rows(); i += 2) x.row(i) *= random.uniform();
  return x;
}

// Each point goes to a level of its own within the band, as far as it gets, within the workspace.
void move_onto_band(const NetworkWeights& barrier, const Box& workspace, double level_band, int moves,
                    Points& x, RandomStream& random) {
  const BasicEvaluator<float> B(barrier);
  const double longest = kLongestMove * workspace.half_widths().maxCoeff();
  Vector level(x.rows()), value;
  for (double& each : level) each = level_band * random.uniform(-1.0, 1.0);
  Points gradient;
  for (int move = 0; move < moves; ++move) {
    B.value_and_gradient(x, value, gradient);
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      const double square = std::max(gradient.row(i).squaredNorm(), std::numeric_limits<double>::min());
      const Vector step = ((level[i] - value[i]) / square) * gradient.row(i).transpose();
      const double length = step.norm(), factor = length > longest ? longest / length : 1.0;
      const Vector to = x.row(i).transpose() + factor * step;
      x.row(i) = to.cwiseMax(workspace.lower).cwiseMin(workspace.upper);
    }
  }
}

}  // namespace

Counterexamples BandFalsifier::find(const Networks& networks, const SafetyProblem& problem, double level_band,
                                    std::uint64_t seed, std::int64_t round) {
  constexpr Condition condition = Condition::barrier_decrease;
  RandomStream random(seed, "falsifier/band", round);
  Points x = spread_points(problem.workspace, samples_, random);
  const auto onto_band = [&](int moves, Points& points) {
    move_onto_band(networks.B, problem.workspace, level_band, moves, points, random);
  };
  onto_band(kMoves, x);
  const Vector rate = residual(condition, networks, problem, level_band, x);  // -infinity off the band
  return climb(condition, networks, problem, level_band, x, rate, near_, random,
               [&](Points& trial) { onto_band(kMovesOfAStep, trial); });
}

}  // namespace s2nnds
