// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/region.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/expression.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string text(const Vector& x) {
  return fmt::format("({})", fmt::join(x.data(), x.data() + x.size(), ", "));
}

Interval side(const Box& box, Eigen::Index axis) { return {box.lower[axis], box.upper[axis]}; }

// |(x - center) / scale| over a box.
Interval scaled_radius(const Box& box, const Vector& center, const Vector& scale) {
  Interval sum = 0.0;
  for (Eigen::Index i = 0; i < center.size(); ++i) sum += square((side(box, i) - center[i]) / scale[i]);
  return sqrt(sum);
}

// The half-space that touches, in the direction of the box, the ellipsoid with its semi-axes grown by the factor: it reaches
// as far along `normal` as its centre does and the length of (normal_i semi_axes_i).
std::optional<HalfspaceBound> touching(const Box& box, const Vector& center, const Vector& semi_axes,
                                       const Interval& factor) {
  const Vector outwards = (box.center() - center).cwiseQuotient(semi_axes.cwiseAbs2());
  const Vector normal = outwards / outwards.norm();
  Interval along = 0.0, squares = 0.0;
  for (Eigen::Index i = 0; i < normal.size(); ++i) {
    along += Interval(normal[i]) * Interval(center[i]);
    squares += square(Interval(normal[i]) * Interval(semi_axes[i]));
  }
  const double offset = (along + factor * sqrt(squares)).upper;
  if (!normal.allFinite() || !std::isfinite(offset)) return std::nullopt;
  return HalfspaceBound{normal, offset};
}

class Empty final : public Region {
 public:
  explicit Empty(Eigen::Index dimension) : dimension_(dimension) {}
  Eigen::Index dimension() const override { return dimension_; }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override { return "none"; }

 protected:
  void evaluate(const Points& x, Vector& level) const override { level.setConstant(x.rows(), kInfinity); }
  // The level is +infinity, which is no point of an interval: all that it must say is "positive".
  Interval enclose(const Box&) const override { return {std::numeric_limits<double>::max(), kInfinity}; }

 private:
  Eigen::Index dimension_;
};

class Ball final : public Region {
 public:
  Ball(const Vector& center, double radius) : center_(center), radius_(radius) {
    check(center.size() > 0 && center.allFinite(), "ball: centre {}, expected finite coordinates",
          text(center));
    check(radius > 0.0 && radius < kInfinity, "ball: radius {}, expected > 0", radius);
  }
  Eigen::Index dimension() const override { return center_.size(); }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override {
    return fmt::format("ball centre {} radius {}", text(center_), radius_);
  }
  std::optional<HalfspaceBound> bounding_halfspace(const Box& box, double level) const override {
    return touching(box, center_, Vector::Ones(center_.size()), Interval(radius_) + level);
  }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    level = (x.rowwise() - center_.transpose()).rowwise().norm().array() - radius_;
  }
  Interval enclose(const Box& box) const override {
    return scaled_radius(box, center_, Vector::Ones(center_.size())) - radius_;
  }

 private:
  Vector center_;
  double radius_;
};

class Ellipsoid final : public Region {
 public:
  Ellipsoid(const Vector& center, const Vector& semi_axes)
      : center_(center), semi_axes_(semi_axes), scale_(semi_axes.size() > 0 ? semi_axes.minCoeff() : 0.0) {
    check(center.size() > 0 && center.allFinite(), "ellipsoid: centre {}, expected finite coordinates",
          text(center));
    check(semi_axes.size() == center.size() && semi_axes.allFinite() && scale_ > 0.0,
          "ellipsoid: semi_axes {}, expected {} numbers > 0", text(semi_axes), center.size());
  }
  Eigen::Index dimension() const override { return center_.size(); }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override {
    return fmt::format("ellipsoid centre {} semi-axes {}", text(center_), text(semi_axes_));
  }
  std::optional<HalfspaceBound> bounding_halfspace(const Box& box, double level) const override {
    return touching(box, center_, semi_axes_, Interval(1.0) + Interval(level) / Interval(scale_));
  }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    const Points scaled = (x.rowwise() - center_.transpose()) * semi_axes_.cwiseInverse().asDiagonal();
    level = scale_ * (scaled.rowwise().norm().array() - 1.0);
  }
  Interval enclose(const Box& box) const override {
    return scale_ * (scaled_radius(box, center_, semi_axes_) - 1.0);
  }

 private:
  Vector center_;
  Vector semi_axes_;
  double scale_;  // the smallest semi-axis: makes the level a length
};

class BoxRegion final : public Region {
 public:
  explicit BoxRegion(const Box& box) : box_(box) {
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
    level.setConstant(x.rows(), -kInfinity);
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      for (Eigen::Index i = 0; i < box_.dimension(); ++i) {
        const double excess = std::max(box_.lower[i] - x(k, i), x(k, i) - box_.upper[i]);
        if (!(excess <= level[k])) level[k] = excess;
        if (std::isnan(excess)) break;
      }
    }
  }
  Interval enclose(const Box& box) const override {
    Interval level(-kInfinity, -kInfinity);
    for (Eigen::Index i = 0; i < box_.dimension(); ++i) {
      if (box_.lower[i] > -kInfinity) level = max(level, box_.lower[i] - side(box, i));
      if (box_.upper[i] < kInfinity) level = max(level, side(box, i) - box_.upper[i]);
    }
    return level;
  }

 private:
  Box box_;
};

class Halfspace final : public Region {
 public:
  Halfspace(const Vector& normal, double offset) : normal_(normal), offset_(offset) {
    check(normal.size() > 0 && normal.allFinite() && normal.norm() > 0.0,
          "halfspace: normal {}, expected finite numbers, not all zero", text(normal));
    check(std::isfinite(offset), "halfspace: offset {}, expected a finite number", offset);
  }
  Eigen::Index dimension() const override { return normal_.size(); }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override {
    return fmt::format("halfspace {} . x <= {}", text(normal_), offset_);
  }
  std::optional<HalfspaceBound> bounding_halfspace(const Box&, double level) const override {
    Interval squares = 0.0;
    for (const double entry : normal_) squares += square(Interval(entry));
    return HalfspaceBound{normal_, (offset_ + level * sqrt(squares)).upper};
  }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    level = ((x * normal_).array() - offset_) / normal_.norm();
  }
  Interval enclose(const Box& box) const override {
    Interval sum = 0.0, squares = 0.0;
    for (Eigen::Index i = 0; i < normal_.size(); ++i) {
      sum += normal_[i] * side(box, i);
      squares += square(normal_[i]);
    }
    return (sum - offset_) / sqrt(squares);
  }

 private:
  Vector normal_;
  double offset_;
};

class ExpressionRegion final : public Region {
 public:
  ExpressionRegion(const std::string& level, Eigen::Index dimension)
      : text_(level), tree_(parse_expression(level, dimension)) {}
  Eigen::Index dimension() const override { return tree_.dimension(); }
  bool is_lipschitz() const override { return false; }
  std::string describe() const override { return fmt::format("{{{} <= 0}}", text_); }

 protected:
  void evaluate(const Points& x, Vector& level) const override { level = tree_.value(x); }
  Interval enclose(const Box& box) const override { return tree_.enclosure(box); }

 private:
  std::string text_;
  ExpressionTree tree_;
};

class PolynomialRegion final : public Region {
 public:
  PolynomialRegion(const Polynomial& level, const std::string& name) : level_(level), name_(name) {}
  Eigen::Index dimension() const override { return level_.dimension(); }
  bool is_lipschitz() const override { return false; }
  std::string describe() const override { return fmt::format("{{{} <= 0}}", name_); }

 protected:
  void evaluate(const Points& x, Vector& level) const override { level = level_.value(x); }
  Interval enclose(const Box& box) const override { return level_.enclosure(box); }

 private:
  Polynomial level_;
  std::string name_;
};

// Union and intersection: the least or the greatest level.
class Combination final : public Region {
 public:
  enum class Kind { unite, intersect };
  Combination(Kind kind, std::vector<RegionPtr> regions) : kind_(kind), regions_(std::move(regions)) {
    check(!regions_.empty(), "{}: no regions, expected at least one", name());
    for (const RegionPtr& region : regions_) {
      check(region != nullptr && region->dimension() == dimension(), "{}: regions of different dimensions",
            name());
    }
  }
  Eigen::Index dimension() const override { return regions_.front()->dimension(); }
  bool is_lipschitz() const override {
    return std::all_of(regions_.begin(), regions_.end(),
                       [](const RegionPtr& region) { return region->is_lipschitz(); });
  }
  std::string describe() const override {
    std::vector<std::string> parts;
    for (const RegionPtr& region : regions_) parts.push_back(region->describe());
    return fmt::format("{} of [{}]", name(), fmt::join(parts, "; "));
  }
  // Of a union, only where one of them meets the box; of an intersection, that of any of them.
  std::optional<HalfspaceBound> bounding_halfspace(const Box& box, double level) const override {
    const Region* only = nullptr;
    for (const RegionPtr& region : regions_) {
      if (kind_ == Kind::intersect) {
        if (auto bound = region->bounding_halfspace(box, level)) return bound;
      } else if (!(region->enclosure(box).lower > level)) {
        if (only != nullptr) return std::nullopt;
        only = region.get();
      }
    }
    return only != nullptr ? only->bounding_halfspace(box, level) : std::nullopt;
  }

 protected:
  void evaluate(const Points& x, Vector& level) const override {
    level = regions_.front()->level(x);
    for (std::size_t i = 1; i < regions_.size(); ++i) {
      const Vector next = regions_[i]->level(x);
      if (kind_ == Kind::unite) {
        level = level.cwiseMin(next);
      } else {
        level = level.cwiseMax(next);
      }
    }
  }
  Interval enclose(const Box& box) const override {
    Interval level = regions_.front()->enclosure(box);
    for (std::size_t i = 1; i < regions_.size(); ++i) {
      const Interval next = regions_[i]->enclosure(box);
      level = kind_ == Kind::unite ? min(level, next) : max(level, next);
    }
    return level;
  }

 private:
  const char* name() const { return kind_ == Kind::unite ? "union" : "intersection"; }

  Kind kind_;
  std::vector<RegionPtr> regions_;
};

class Complement final : public Region {
 public:
  explicit Complement(RegionPtr region) : region_(std::move(region)) {
    check(region_ != nullptr, "complement: no region");
  }
  Eigen::Index dimension() const override { return region_->dimension(); }
  bool is_lipschitz() const override { return region_->is_lipschitz(); }
  std::string describe() const override { return fmt::format("complement of [{}]", region_->describe()); }

 protected:
  void evaluate(const Points& x, Vector& level) const override { level = -region_->level(x); }
  // Negating the level, not the answer, keeps the boundary in the closed complement.
  Interval enclose(const Box& box) const override { return -region_->enclosure(box); }

 private:
  RegionPtr region_;
};

}  // namespace

// The messages are put together only when they are needed: describe() costs more than a level.
Vector Region::level(const Points& x) const {
  if (x.cols() != dimension()) {
    fail("{}: points of dimension {}, expected {}", describe(), x.cols(), dimension());
  }
  Vector result;
  evaluate(x, result);
  for (Eigen::Index k = 0; k < result.size(); ++k) {
    if (!std::isnan(result[k])) continue;
    fail("{}: the level is not a number at {}", describe(), text(x.row(k).transpose()));
  }
  return result;
}

bool Region::contains(const Eigen::Ref<const Vector>& x) const { return level(x.transpose())[0] <= 0.0; }

Interval Region::enclosure(const Box& box) const {
  if (box.dimension() != dimension()) {
    fail("{}: box of dimension {}, expected {}", describe(), box.dimension(), dimension());
  }
  // An infinite lower bound of +infinity (or the mirror image) holds no real point: nothing can be said of
  // it.
  const bool real =
      !box.is_empty() && (box.lower.array() < kInfinity).all() && (box.upper.array() > -kInfinity).all();
  return real ? enclose(box) : Interval::undefined();
}

Location Region::classify(const Box& box) const {
  const Interval level = enclosure(box);
  if (level.upper <= 0.0) return Location::inside;
  if (level.lower > 0.0) return Location::outside;
  return Location::unknown;
}

RegionPtr empty_region(Eigen::Index dimension) { return std::make_shared<Empty>(dimension); }
RegionPtr ball(const Vector& center, double radius) { return std::make_shared<Ball>(center, radius); }
RegionPtr box_region(const Box& box) { return std::make_shared<BoxRegion>(box); }
RegionPtr ellipsoid(const Vector& center, const Vector& semi_axes) {
  return std::make_shared<Ellipsoid>(center, semi_axes);
}
RegionPtr halfspace(const Vector& normal, double offset) {
  return std::make_shared<Halfspace>(normal, offset);
}
RegionPtr expression(const std::string& level, Eigen::Index dimension) {
  return std::make_shared<ExpressionRegion>(level, dimension);
}
RegionPtr polynomial(const Polynomial& level, const std::string& name) {
  return std::make_shared<PolynomialRegion>(level, name);
}
RegionPtr unite(std::vector<RegionPtr> regions) {
  return std::make_shared<Combination>(Combination::Kind::unite, std::move(regions));
}
RegionPtr intersect(std::vector<RegionPtr> regions) {
  return std::make_shared<Combination>(Combination::Kind::intersect, std::move(regions));
}
RegionPtr complement(RegionPtr region) { return std::make_shared<Complement>(std::move(region)); }

bool may_meet(const Region& region, const Box& box, int bisections) {
  switch (region.classify(box)) {
    case Location::inside:
      return true;
    case Location::outside:
      return false;
    case Location::unknown:
      break;
  }
  if (bisections == 0) return true;
  const auto [left, right] = box.bisect(box.widest_side());
  return may_meet(region, left, bisections - 1) || may_meet(region, right, bisections - 1);
}

}  // namespace s2nnds
