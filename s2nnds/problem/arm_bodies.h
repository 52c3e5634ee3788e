// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/problem/kinematic_chain.h"

namespace s2nnds {

// A ball that moves with a frame of an arm.
struct BodySphere {
  Eigen::Index frame = 0;
  Eigen::Vector3d center;  // as seen from the frame
  double radius = 0.0;
};

// What an arm consists of, as a configuration writes it. All lengths in the unit of the chain.
struct ArmBodies {
  double radius = 0.0;           // > 0: of capsules from every frame's origin to the next, and to the tip
  std::vector<double> tip = {};  // [3], as seen from the last frame; none: that frame's origin
  std::vector<std::vector<double>> spheres = {};  // [frame, x, y, z, radius]
  std::vector<std::vector<double>> capsules =
      {};  // [frame, x, y, z, x, y, z, radius], from one end to the other
};

// Spheres that together hold these bodies. A capsule is covered by spheres along its axis, 0.8 of its radius apart or
// less, which are so much larger (by 8 %) that their union contains it, rounding included; a long thin one by 64 that are
// larger still. Bodies that no joint moves are left out: no motion avoids what they touch. Throws Error for a row of
// another length, numbers that are not finite, a radius that is not > 0, frames that do not exist, and where nothing is
// left that moves.
std::vector<BodySphere> cover_bodies(const ArmBodies& bodies, const KinematicChain& chain);

}  // namespace s2nnds
