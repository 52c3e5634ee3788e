// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/region.h"
#include "s2nnds/problem/rotation.h"

namespace s2nnds {

// The region turned by `rotation` and then moved by `shift` [n]; level: the region's at what x was before.
// `text` is what describe() gives. Throws Error unless the dimensions fit and `shift` is finite.
RegionPtr placed(RegionPtr region, const Rotation& rotation, const Vector& shift, const std::string& text);

// The box lower <= x <= upper, with infinite sides if need be; level: the signed distance, unlike that of
// box_region(). Throws Error if `box` is empty.
RegionPtr distance_box(const Box& box);
// The box of these half sizes [n] around `center` [n], turned about it; level: the signed distance. Throws
// Error unless all is finite, of one dimension, and the half sizes are > 0.
RegionPtr oriented_box(const Vector& center, const Vector& half_sizes, const Rotation& rotation);

}  // namespace s2nnds
