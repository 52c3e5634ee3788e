// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/tube.h"

#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/surface_region.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string text(const Vector& x) {
  return fmt::format("({})", fmt::join(x.data(), x.data() + x.size(), ", "));
}

std::string described(const char* name, const Vector& start, const Vector& end, double radius) {
  return fmt::format("{} from {} to {} radius {}", name, text(start), text(end), radius);
}

using Intervals = std::array<Interval, 3>;

Interval length(const Intervals& x) { return sqrt(square(x[0]) + square(x[1]) + square(x[2])); }

class Cylinder final : public Region {
 public:
  Cylinder(const Vector& start, const Vector& end, double radius)
      : start_(start), end_(end), middle_(0.5 * start + 0.5 * end), radius_(radius) {
    check(start.size() == 3 && end.size() == 3, "cylinder: found start {} and end {}, expected 3 coordinates",
          text(start), text(end));
    check(start.allFinite() && end.allFinite() && (end - start).norm() > 0.0,
          "cylinder: found start {} and end {}, expected two finite points that differ", text(start),
          text(end));
    check(radius > 0.0 && radius < kInfinity, "cylinder: radius {}, expected > 0", radius);
    axis_ = (end - start).normalized();
    half_length_ = 0.5 * (end - start).norm();
  }
  Eigen::Index dimension() const override { return 3; }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override { return described("cylinder", start_, end_, radius_); }

 protected:
  // The signed distance from a rectangle, in the plane of the axis and x.
  void evaluate(const Points& x, Vector& level) const override {
    level.resize(x.rows());
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      const Eigen::Vector3d to = x.row(k).transpose() - middle_;
      const double along = to.dot(axis_);
      const double beyond = std::abs(along) - half_length_, aside = (to - along * axis_).norm() - radius_;
      level[k] = x.row(k).hasNaN() ? std::numeric_limits<double>::quiet_NaN()
                                   : std::hypot(std::max(beyond, 0.0), std::max(aside, 0.0)) +
                                         std::min(std::max(beyond, aside), 0.0);
    }
  }
  Interval enclose(const Box& box) const override {
    if (!box.is_finite()) return {-kInfinity, kInfinity};
    const Vector center = box.center();
    const Interval around = lipschitz_enclosure(level_over({center, center}), box);
    return intersection(level_over(box), around);
  }

 private:
  // What evaluate() does, by intervals, from the end points alone: what the constructor rounded is not used.
  Interval level_over(const Box& box) const {
    Intervals to, axis;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      axis[k] = Interval(end_[i]) - start_[i];
      to[k] = Interval(box.lower[i], box.upper[i]) - Interval(0.5) * (Interval(start_[i]) + end_[i]);
    }
    const Interval whole = length(axis);
    Interval along = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      axis[i] = axis[i] / whole;
      along += axis[i] * to[i];
    }
    // Aside: of (I - a a^T) to, each entry of which holds each coordinate once.
    Intervals aside;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        aside[i] += (Interval(i == j ? 1.0 : 0.0) - axis[i] * axis[j]) * to[j];
      }
    }
    const Interval outside = length(aside) - radius_, beyond = abs(along) - Interval(0.5) * whole;
    const Interval corner = sqrt(square(max(beyond, 0.0)) + square(max(outside, 0.0)));
    const Interval larger = max(beyond, outside);
    return larger.lower > 0.0 ? corner : corner + min(larger, 0.0);
  }

  Vector start_, end_;
  Eigen::Vector3d middle_, axis_;
  double radius_, half_length_ = 0.0;
};

}  // namespace

RegionPtr capsule(const Vector& start, const Vector& end, double radius) {
  check(start.size() == end.size() && start.size() > 0 && start.allFinite() && end.allFinite(),
        "capsule: found start {} and end {}, expected two finite points", text(start), text(end));
  Points ends(2, start.size());
  ends.row(0) = start.transpose();
  ends.row(1) = end.transpose();
  return thickened(SimplexSet(ends, Eigen::MatrixXi{{0, 1}}), radius,
                   described("capsule", start, end, radius));
}

RegionPtr cylinder(const Vector& start, const Vector& end, double radius) {
  return std::make_shared<Cylinder>(start, end, radius);
}

}  // namespace s2nnds
