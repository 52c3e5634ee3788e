// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/placed_region.h"

#include <fmt/ranges.h>

#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/simplex.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string text(const Vector& x) {
  return fmt::format("({})", fmt::join(x.data(), x.data() + x.size(), ", "));
}

class Placed final : public Region {
 public:
  Placed(RegionPtr region, const Rotation& rotation, const Vector& shift, const std::string& text)
      : region_(std::move(region)), rotation_(rotation), shift_(shift), text_(text) {
    check(region_->dimension() == shift.size() && rotation.matrix.rows() == shift.size() && shift.allFinite(),
          "{}: found {} finite coordinates and a rotation in {} dimensions, expected {} of both", text,
          shift.size(), rotation.matrix.rows(), region_->dimension());
  }
  Eigen::Index dimension() const override { return shift_.size(); }
  bool is_lipschitz() const override { return region_->is_lipschitz(); }
  std::string describe() const override { return text_; }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    const Points moved = x.rowwise() - shift_.transpose();
    level = region_->level(moved * rotation_.matrix);
  }
  Interval enclose(const Box& box) const override {
    if (!box.is_finite()) return {-kInfinity, kInfinity};
    const Interval level = region_->enclosure(before(box));
    if (!is_lipschitz()) return level;
    // The box around a turned box is larger than it; the Lipschitz bound is not.
    const Vector center = box.center();
    return intersection(level, lipschitz_enclosure(region_->enclosure(before({center, center})), box));
  }

 private:
  // Around what the box was before it was placed.
  Box before(const Box& box) const {
    Box result{Vector(dimension()), Vector(dimension())};
    for (Eigen::Index i = 0; i < dimension(); ++i) {
      Interval sum = 0.0;
      for (Eigen::Index j = 0; j < dimension(); ++j) {
        const Interval entry = rotation_.enclosure[static_cast<std::size_t>(j * dimension() + i)];
        sum += entry * (Interval(box.lower[j], box.upper[j]) - shift_[j]);
      }
      result.lower[i] = sum.lower;
      result.upper[i] = sum.upper;
    }
    return result;
  }

  RegionPtr region_;
  Rotation rotation_;
  Vector shift_;
  std::string text_;
};

class DistanceBox final : public Region {
 public:
  explicit DistanceBox(const Box& box) : box_(box) {
    check(box.dimension() > 0 && !box.is_empty(), "box: lower {} and upper {}, expected lower <= upper",
          text(box.lower), text(box.upper));
  }
  Eigen::Index dimension() const override { return box_.dimension(); }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override {
    return fmt::format("box lower {} upper {}", text(box_.lower), text(box_.upper));
  }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    level.resize(x.rows());
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      const auto row = x.row(k).transpose();
      const Vector excess = (box_.lower - row).cwiseMax(row - box_.upper);
      level[k] = row.hasNaN() ? std::numeric_limits<double>::quiet_NaN()
                              : excess.cwiseMax(0.0).norm() + std::min(excess.maxCoeff(), 0.0);
    }
  }
  Interval enclose(const Box& box) const override {
    Interval largest(-kInfinity, -kInfinity), squares = 0.0;
    for (Eigen::Index i = 0; i < box_.dimension(); ++i) {
      const Interval side(box.lower[i], box.upper[i]);
      Interval excess(-kInfinity, -kInfinity);
      if (box_.lower[i] > -kInfinity) excess = max(excess, box_.lower[i] - side);
      if (box_.upper[i] < kInfinity) excess = max(excess, side - box_.upper[i]);
      largest = max(largest, excess);
      squares += square(max(excess, 0.0));
    }
    return largest.lower > 0.0 ? sqrt(squares) : sqrt(squares) + min(largest, 0.0);
  }

 private:
  Box box_;
};

}  // namespace

RegionPtr placed(RegionPtr region, const Rotation& rotation, const Vector& shift, const std::string& text) {
  return std::make_shared<Placed>(std::move(region), rotation, shift, text);
}

RegionPtr distance_box(const Box& box) { return std::make_shared<DistanceBox>(box); }

RegionPtr oriented_box(const Vector& center, const Vector& half_sizes, const Rotation& rotation) {
  check(half_sizes.size() == center.size() && half_sizes.allFinite() && half_sizes.minCoeff() > 0.0,
        "oriented_box: half_sizes {}, expected {} numbers > 0", text(half_sizes), center.size());
  return placed(distance_box({-half_sizes, half_sizes}), rotation, center,
                fmt::format("box centre {} half sizes {}{}{}", text(center), text(half_sizes),
                            rotation.text.empty() ? "" : " ", rotation.text));
}

}  // namespace s2nnds
