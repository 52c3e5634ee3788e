// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/level_distance.h"

#include <gtest/gtest.h>

#include "s2nnds/problem/region_sampler.h"
#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

// Samples of {B >= 0} are never nearer than told, and some are nearly as near.
TEST(LevelDistance, IsBelowTheTrueOneAndNearIt) {
  const Networks networks = simple_networks();
  const SafetyProblem problem = simple_problem();
  const ProofFunctions functions = ProofFunctions::of(networks);
  const LevelDistance distance(functions, problem);
  RandomStream random(5, "level distance");
  const Points all = uniform_points(problem.workspace, 200000, random), value = networks.B.value(all);
  std::vector<Eigen::Index> outside;
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    if (value(i, 0) >= 0.0) outside.push_back(i);
  }
  const Points beyond = all(outside, Eigen::all), x = uniform_points(problem.workspace, 200, random),
               at = networks.B.value(x);
  const Vector below = distance.below(x);
  int positive = 0;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    if (at(i, 0) >= 0.0) {
      EXPECT_EQ(below[i], 0.0);
      continue;
    }
    const double sampled = (beyond.rowwise() - x.row(i)).rowwise().norm().minCoeff();
    EXPECT_LE(below[i], sampled);
    EXPECT_GE(below[i], sampled - 0.03);
    positive += below[i] > 0.0;
  }
  EXPECT_GT(positive, 50);
}

TEST(LevelDistance, IsNothingWhereNothingIsCertain) {
  Networks networks = simple_networks();
  networks.B.layers.back().weight *= 1e200;
  const ProofFunctions functions = ProofFunctions::of(networks);
  const LevelDistance distance(functions, simple_problem());
  EXPECT_EQ(distance.below(Points::Zero(1, 2))[0], 0.0);
}

}  // namespace
}  // namespace s2nnds
