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
      level[k] = x.row(k).allFinite() ? core_.distance(x.row(k).transpose()).upper - radius_
                                      : std::numeric_limits<double>::quiet_NaN();
    }
  }
  Interval enclose(const Box& box) const override {
    if (!box.is_finite()) return {-kInfinity, kInfinity};
    return core_.distance_over(box) - radius_;
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
    level[k] =
        at.allFinite() ? side(at) * surface_.distance(at).upper : std::numeric_limits<double>::quiet_NaN();
  }
}

Interval SurfaceRegion::enclose(const Box& box) const {
  if (!box.is_finite()) return {-kInfinity, kInfinity};
  const Position center = box.center();
  const Interval distance = surface_.distance(center);
  // A box that the surface does not meet lies on one side of it; of others only the Lipschitz bound holds.
  const double gap = surface_.gap(box);
  const int sign = gap > 0.0 ? side(center) : 0;
  if (sign == 0) return lipschitz_enclosure({-distance.upper, distance.upper}, box);
  const Interval around = lipschitz_enclosure(distance, box);
  const Interval level(std::max(gap, around.lower), around.upper);
  return sign > 0 ? level : -level;
}

RegionPtr thickened(SimplexSet core, double radius, const std::string& text) {
  return std::make_shared<Thickened>(std::move(core), radius, text);
}

}  // namespace s2nnds
