// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/extruded_region.h"

#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

class ExtrudedRegion final : public Region {
 public:
  ExtrudedRegion(RegionPtr region, double from, double to)
      : region_(std::move(region)), from_(from), to_(to) {
    check(region_ != nullptr && from <= to, "extrusion: found from = {} and to = {}, expected from <= to",
          from, to);
  }
  Eigen::Index dimension() const override { return region_->dimension() + 1; }
  bool is_lipschitz() const override { return region_->is_lipschitz(); }
  std::string describe() const override {
    if (std::isinf(from_) && std::isinf(to_))
      return fmt::format("{}, whatever the last coordinate", region_->describe());
    return fmt::format("{}, the last coordinate from {} to {}", region_->describe(), from_, to_);
  }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    const Eigen::Index n = region_->dimension();
    level = region_->level(x.leftCols(n));
    const auto s = x.col(n).array();
    level = level.array().max(from_ - s).max(s - to_);
  }
  Interval enclose(const Box& box) const override {
    const Eigen::Index n = region_->dimension();
    const Interval s(box.lower[n], box.upper[n]);
    const Interval level = region_->enclosure({box.lower.head(n), box.upper.head(n)});
    return max(max(level, from_ - s), s - to_);
  }

 private:
  RegionPtr region_;
  double from_, to_;
};

}  // namespace

RegionPtr extruded(RegionPtr region, double from, double to) {
  return std::make_shared<ExtrudedRegion>(std::move(region), from, to);
}

}  // namespace s2nnds
