// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/problem/region.h"
#include "s2nnds/problem/simplex_set.h"

namespace s2nnds {

// A region within a closed surface of segments (2-D) or triangles (3-D). Level: the distance to the surface,
// negative inside: the signed distance. Enclosures of boxes that the surface does not meet are as tight as
// the distance of a box is; those of others are the Lipschitz bound.
class SurfaceRegion : public Region {
 public:
  explicit SurfaceRegion(SimplexSet surface) : surface_(std::move(surface)) {}
  Eigen::Index dimension() const override { return surface_.dimension(); }
  bool is_lipschitz() const override { return true; }

 protected:
  // -1 inside, 1 outside, proved in interval arithmetic; 0 where that could not be said, near the surface.
  virtual int side(const Position& x) const = 0;
  // The distance to the surface, up to rounding; no proof rests on it.
  virtual double rounded_distance(const Position& x) const { return surface_.rounded_distance(x); }
  const SimplexSet& surface() const { return surface_; }

  void evaluate(const Points& x, Vector& level) const override;
  Interval enclose(const Box& box) const override;

 private:
  SimplexSet surface_;
};

// All points within `radius` of the set of simplices: tubes and clouds. Level: the distance less the radius,
// outside the signed distance; `text` is what describe() gives. Throws Error unless radius is > 0 and finite.
RegionPtr thickened(SimplexSet core, double radius, const std::string& text);

}  // namespace s2nnds
