// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/framed_region.h"

#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

class FramedRegion final : public Region {
 public:
  FramedRegion(RegionPtr region, const Vector& goal, double scale)
      : region_(std::move(region)), goal_(goal), scale_(scale) {
    check(
        region_ != nullptr && goal.size() == region_->dimension() && goal.allFinite(),
        "framed region: found a goal of dimension {}, expected finite coordinates of the region's dimension",
        goal.size());
    check(scale > 0.0 && std::isfinite(scale), "framed region: scale {}, expected > 0", scale);
  }
  Eigen::Index dimension() const override { return region_->dimension(); }
  // Both lengths are divided by the scale.
  bool is_lipschitz() const override { return region_->is_lipschitz(); }
  std::string describe() const override { return region_->describe(); }
  // normal . (scale z + goal) <= offset; the normal's rounding, times what z is at most in the box, is allowed for.
  std::optional<HalfspaceBound> bounding_halfspace(const Box& box, double level) const override {
    const double before = (Interval(level) * Interval(scale_)).upper;
    std::optional<HalfspaceBound> bound = region_->bounding_halfspace(image_of(box), before);
    if (!bound) return bound;
    Interval offset = bound->offset;
    for (Eigen::Index i = 0; i < dimension(); ++i) {
      const Interval exact = Interval(bound->normal[i]) * Interval(scale_);
      offset = offset - Interval(bound->normal[i]) * Interval(goal_[i]);
      bound->normal[i] = exact.lower;
      offset = offset + (Interval(exact.lower) - exact) * Interval(box.lower[i], box.upper[i]);
    }
    bound->offset = offset.upper;
    return bound;
  }

 protected:
  void evaluate(const Points& z, Vector& level) const override {
    level = region_->level((scale_ * z).rowwise() + goal_.transpose()) / scale_;
  }
  Interval enclose(const Box& box) const override {
    return region_->enclosure(image_of(box)) / Interval(scale_);
  }

 private:
  Box image_of(const Box& box) const {
    Box image = box;
    for (Eigen::Index i = 0; i < dimension(); ++i) {
      image.lower[i] = (goal_[i] + Interval(scale_) * Interval(box.lower[i])).lower;
      image.upper[i] = (goal_[i] + Interval(scale_) * Interval(box.upper[i])).upper;
    }
    return image;
  }

  RegionPtr region_;
  Vector goal_;
  double scale_;
};

}  // namespace

RegionPtr framed(RegionPtr region, const Vector& goal, double scale) {
  return std::make_shared<FramedRegion>(std::move(region), goal, scale);
}

}  // namespace s2nnds
