// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/smoothed_velocity.h"

#include "s2nnds/core/check.h"
#include "s2nnds/training/phase_regression.h"

namespace s2nnds {

std::vector<Demonstration> smoothed(std::vector<Demonstration> demonstrations, double share) {
  check(share >= 0.0 && share <= 1.0, "smoothing: the share is {}, expected 0 to 1", share);
  if (share == 0.0 || demonstrations.size() < 2) return demonstrations;
  const PhaseRegression regression(demonstrations);
  for (Demonstration& each : demonstrations) {
    each.velocity += share * (regression.velocity(each.position) - each.velocity);
  }
  return demonstrations;
}

}  // namespace s2nnds
