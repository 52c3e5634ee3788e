// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// The velocity at a point that the demonstrations of one motion agree on: Gaussian mixture regression
// (Calinon, Guenter and Billard, On Learning, Representing, and Generalizing a Task in a Humanoid Robot,
// 2007). The components are not found by expectation maximisation: there is one at each of some phases of the
// motion, 0 its start and 1 its end. Which samples are at one phase is found by dynamic time warping to the
// mean motion, so a component describes the same place of the motion in all demonstrations, however fast each
// came there. Normalised units.
class PhaseRegression {
 public:
  // Throws Error unless there are at least two demonstrations.
  explicit PhaseRegression(const std::vector<Demonstration>& demonstrations);

  Points velocity(const Points& x) const;  // [N, n] -> [N, n]
  // How far the demonstrations lie from their mean at the phases of x: standard deviation of the position,
  // [N, n] -> [N].
  Vector spread(const Points& x) const;

 private:
  // The velocity where a sample of this phase is at x: velocity + slope (x - position). The logarithm of the
  // phase's density at x, but for a constant: log_scale - |whitening (x - position)|^2 / 2.
  struct Component {
    Vector position, velocity;
    Eigen::MatrixXd slope, whitening;
    double log_scale;
    double spread;  // standard deviation of the positions, all axes together
  };

  // The share of each component's phase in points x [N, n]: [N, components].
  Points responsibilities(const Points& x) const;

  std::vector<Component> components_;
};

}  // namespace s2nnds
