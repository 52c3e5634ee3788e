// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/region.h"

namespace s2nnds {

// The joint angles at which an arm touches an obstacle, which is any region in space: `dh`, `convention`, `base`,
// `rotation`, the bodies and `obstacles` of a region of type "arm", n = `dimension` joints.
//
// The bodies are spheres (cover_bodies); the set is where one's centre lies in the obstacle grown by its radius
// (inflated()). level: the least over the spheres of the grown obstacle's level at the centre, divided by L, the root of
// the sum over the joints of the squares of how far the centre is from the joint's axis at most. So the level is an angle,
// as the joints are, and 1-Lipschitz where the obstacle's is: never more than the distance to the set, often a third of it.
//
// Boxes: at the box's middle the grown obstacle's level, which changes by at most the sum of reach times half width; where
// that leaves it open, the grown obstacle's enclosure over the box of the centre's places, by interval kinematics, both
// directly and by the mean value theorem.
//
// Throws Error saying which key is wrong.
RegionPtr arm_region(const RegionOptions& options, Eigen::Index dimension, RegionFiles& files);

}  // namespace s2nnds
