// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/smoothed_velocity.h"

#include "s2nnds/core/check.h"
#include "s2nnds/training/phase_regression.h"

namespace s2nnds {
namespace {

// The spread of the demonstrations up to which velocities are smoothed wholly, and from which on not at all:
// what motions that lie far apart do otherwise is no noise.
constexpr double kWholeWithin = 0.15, kNoneBeyond = 0.3;

}  // namespace

std::vector<Demonstration> smoothed(std::vector<Demonstration> demonstrations, double share) {
  check(share >= 0.0 && share <= 1.0, "smoothing: the share is {}, expected 0 to 1", share);
  if (share == 0.0 || demonstrations.size() < 2) return demonstrations;
  const PhaseRegression regression(demonstrations);
  for (Demonstration& each : demonstrations) {
    const Vector factor =
        ((kNoneBeyond - regression.spread(each.position).array()) / (kNoneBeyond - kWholeWithin))
            .cwiseMax(0.0)
            .cwiseMin(1.0);
    each.velocity += share * factor.asDiagonal() * (regression.velocity(each.position) - each.velocity);
  }
  return demonstrations;
}

}  // namespace s2nnds
