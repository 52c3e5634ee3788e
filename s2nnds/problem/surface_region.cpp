// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/surface_region.h"

#include <algorithm>
#include <limits>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Thickened final : public Region {
 public:
  Thickened(SimplexSet core, double radius, const std::string& text)
      : core_(std::move(core)), radius_(radius), text_(text) {
    check(radius > 0.0 && radius < kInfinity, "{}: radius {}, expected > 0", text, radius);
  }
  Eigen::Index dimension() const override { return core_.dimension(); }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override { return text_; }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    level.resize(x.rows());
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      level[k] = x.row(k).allFinite() ? core_.rounded_distance(x.row(k).transpose()) - radius_
                                      : std::numeric_limits<double>::quiet_NaN();
    }
  }
  Interval enclose(const Box& box) const override {
    if (!box.is_finite()) return {-kInfinity, kInfinity};
    // Where the distance of the centre says how the box lies to the set, that of the box need not be known.
    const Interval around = lipschitz_enclosure(core_.distance(box.center()), box) - radius_;
    if (around.lower > 0.0 || around.upper <= 0.0) return around;
    const Interval from_gap = Interval(core_.gap(box)) - radius_;
    return {std::max(around.lower, from_gap.lower), around.upper};
  }

 private:
  SimplexSet core_;
  double radius_;
  std::string text_;
};

}  // namespace

void SurfaceRegion::evaluate(const Points& x, Vector& level) const {
  level.resize(x.rows());
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    const Position at = x.row(k).transpose();
    level[k] = at.allFinite() ? side(at) * rounded_distance(at) : std::numeric_limits<double>::quiet_NaN();
  }
}

Interval SurfaceRegion::enclose(const Box& box) const {
  if (!box.is_finite()) return {-kInfinity, kInfinity};
  const Position center = box.center();
  const Interval distance = surface_.distance(center), around = lipschitz_enclosure(distance, box);
  // The distance of the whole box is worth its time only near the surface.
  const bool far = distance.lower > 2.0 * half_diagonal(box);
  const double least = far ? around.lower : std::max(around.lower, surface_.gap(box));
  const int sign = side(center);
  if (sign == 0) return lipschitz_enclosure({-distance.upper, distance.upper}, box);
  // A box that the surface does not meet lies on one side of it; of others only the Lipschitz bound holds.
  const Interval level(least > 0.0 ? least : around.lower, around.upper);
  return sign > 0 ? level : -level;
}

RegionPtr thickened(SimplexSet core, double radius, const std::string& text) {
  return std::make_shared<Thickened>(std::move(core), radius, text);
}

}  // namespace s2nnds
