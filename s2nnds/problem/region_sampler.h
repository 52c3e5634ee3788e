// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "s2nnds/core/random.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {

// Draws i.i.d. uniform points of a region within a box. Paves the box once into sub-boxes that the region
// calls inside or unknown, picks them by volume and rejects, so that small or thin sets cost few draws.
class RegionSampler {
 public:
  // Throws Error unless `within` is finite and of the region's dimension.
  RegionSampler(RegionPtr region, const Box& within);

  // No point was found: the region is (as far as sampling can tell) empty within the box. True for sets
  // without volume.
  bool empty() const { return cover_.empty(); }
  // [count, n]. Throws Error if empty. With a stock the points are no longer independent.
  Points sample(std::size_t count, RandomStream& random) const;
  // Draws `count` points, of which all samples from now on take seven in eight, and draw the others anew: for training,
  // where points of a thin set of many dimensions cost more than all else. Nothing if empty.
  void keep_stock(std::size_t count, RandomStream& random);
  // Least volume of the region within the box: of the sub-boxes that lie inside; 0 if empty.
  double volume_inside() const { return volume_inside_; }
  // Greatest volume of the region within the box: of all sub-boxes that may hold points; 0 if empty.
  double volume_cover() const { return volume_cover_; }

 private:
  void pave(const Box& within);
  void draw(Points& candidates, std::vector<bool>& accepted, RandomStream& random) const;

  RegionPtr region_;
  std::vector<Box> cover_;
  std::vector<double> cumulative_volume_;
  std::vector<bool> inside_;
  double volume_inside_ = 0.0;
  double volume_cover_ = 0.0;
  Points stock_;  // [count, n] or none
};

// A sampler of the region; none for no region, and for one that is empty within the box.
std::optional<RegionSampler> sampler_of(const RegionPtr& region, const Box& within);

// i.i.d. uniform points of a finite box: [count, n].
Points uniform_points(const Box& box, std::int64_t count, RandomStream& random);

}  // namespace s2nnds
