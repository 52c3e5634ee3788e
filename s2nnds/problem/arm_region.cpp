// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/arm_region.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/arm_bodies.h"
#include "s2nnds/problem/inflated_region.h"
#include "s2nnds/problem/kinematic_chain.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDegree = M_PI / 180.0;
constexpr Eigen::Index kRows = 512;  // joint positions whose spheres are looked at together

using Place = std::array<Interval, 3>;

// The balls of one radius, and the obstacle grown by it.
struct Spheres {
  RegionPtr grown;
  std::vector<BodySphere> all;
  std::vector<std::vector<double>>
      reaches;                 // of each ball: how far it moves, at most, with each joint's unit
  std::vector<double> scales;  // L of each
};

Place sum(const Place& a, const Place& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

Place common(const Place& a, const Place& b) {
  return {intersection(a[0], b[0]), intersection(a[1], b[1]), intersection(a[2], b[2])};
}

Box box_of(const Place& place) {
  Box box{Vector(3), Vector(3)};
  for (Eigen::Index i = 0; i < 3; ++i) {
    box.lower[i] = place[static_cast<std::size_t>(i)].lower;
    box.upper[i] = place[static_cast<std::size_t>(i)].upper;
  }
  return box;
}

class ArmRegion final : public Region {
 public:
  ArmRegion(KinematicChain chain, std::vector<Spheres> bodies, bool degrees, const std::string& text)
      : chain_(std::move(chain)), bodies_(std::move(bodies)), degrees_(degrees), text_(text) {}
  Eigen::Index dimension() const override { return chain_.joints(); }
  bool is_lipschitz() const override {
    return std::all_of(bodies_.begin(), bodies_.end(),
                       [](const Spheres& spheres) { return spheres.grown->is_lipschitz(); });
  }
  std::string describe() const override { return text_; }

 protected:
  void evaluate(const Points& q, Vector& level) const override {
    level.setConstant(q.rows(), kInfinity);
    for (Eigen::Index from = 0; from < q.rows(); from += kRows)
      evaluate_some(q.middleRows(from, std::min(kRows, q.rows() - from)), level.data() + from);
  }

  Interval enclose(const Box& box) const override {
    if (!box.is_finite()) return {-kInfinity, kInfinity};
    const Look look(*this, box);
    Interval level(kInfinity, kInfinity);
    for (const Spheres& spheres : bodies_) {
      for (std::size_t k = 0; k < spheres.all.size(); ++k)
        level = min(level, look.level(spheres, k) / Interval(spheres.scales[k]));
    }
    return level;
  }

 private:
  using Frames = std::vector<FramePose<Interval>>;

  // A box of joint angles, looked at ball by ball.
  class Look {
   public:
    Look(const ArmRegion& arm, const Box& box) : arm_(arm), half_widths_(box.half_widths()) {
      const Vector middle = box.center();
      std::vector<Interval> at_middle;
      for (Eigen::Index i = 0; i < box.dimension(); ++i) {
        at_middle.push_back(arm.radians(middle[i]));
        over_box_.push_back(arm.radians({box.lower[i], box.upper[i]}));
        turns_.push_back(arm.radians({-half_widths_[i], half_widths_[i]}));
      }
      middle_ = arm.chain_.frames(at_middle);
    }

    // Holds the grown obstacle's level at the centre of one ball.
    Interval level(const Spheres& spheres, std::size_t k) const {
      const BodySphere& sphere = spheres.all[k];
      const auto frame = static_cast<std::size_t>(sphere.frame);
      const Place middle = sum(middle_[frame].origin, middle_[frame].turned(sphere.center));
      Interval around(-kInfinity, kInfinity);
      if (spheres.grown->is_lipschitz()) {
        around = spheres.grown->enclosure(box_of(middle)) + moved(spheres.reaches[k]);
        if (around.lower > 0.0 || around.upper <= 0.0) return around;
      }
      return intersection(around, spheres.grown->enclosure(box_of(places(sphere, middle))));
    }

   private:
    Interval moved(const std::vector<double>& reach) const {
      Interval sum = 0.0;
      for (std::size_t i = 0; i < reach.size(); ++i)
        sum += Interval(reach[i]) * Interval(half_widths_[static_cast<Eigen::Index>(i)]);
      return {-sum.upper, sum.upper};
    }

    // Where the ball's centre lies: directly, and by the mean value theorem, with dc / dq_i = axis_i x (c - a place on it).
    Place places(const BodySphere& sphere, const Place& middle) const {
      if (frames_.empty()) frames_ = arm_.chain_.frames(over_box_);
      const auto frame = static_cast<std::size_t>(sphere.frame);
      Place arm = frames_[frame].turned(sphere.center);  // from an origin to the centre, link by link
      const Place direct = sum(frames_[frame].origin, arm);
      Place mean = middle;
      for (std::size_t from = frame, i = frame; i >= 1; --i) {
        const auto axis = static_cast<std::size_t>(arm_.chain_.axis_of(static_cast<Eigen::Index>(i)));
        for (; from > axis; --from) arm = sum(arm, frames_[from].step);
        const auto& z = frames_[axis].axes;
        const Interval& turn = turns_[i - 1];
        mean[0] += (z[5] * arm[2] - z[8] * arm[1]) * turn;
        mean[1] += (z[8] * arm[0] - z[2] * arm[2]) * turn;
        mean[2] += (z[2] * arm[1] - z[5] * arm[0]) * turn;
      }
      return common(direct, mean);
    }

    const ArmRegion& arm_;
    Vector half_widths_;
    std::vector<Interval> over_box_;
    std::vector<Interval> turns_;  // from the middle, in rad
    Frames middle_;
    mutable Frames frames_;  // over the whole box, once they are needed
  };

  Interval radians(const Interval& angle) const {
    return degrees_ ? angle * pi_interval() / Interval(180.0) : angle;
  }

  void evaluate_some(const Points& q, double* level) const {
    const Eigen::Index joints = chain_.joints();
    std::vector<std::vector<FramePose<double>>> frames;
    std::vector<double> angles(static_cast<std::size_t>(joints));
    for (Eigen::Index row = 0; row < q.rows(); ++row) {
      const bool finite = q.row(row).allFinite();
      if (!finite) level[row] = std::numeric_limits<double>::quiet_NaN();
      for (Eigen::Index i = 0; i < joints; ++i)
        angles[static_cast<std::size_t>(i)] = finite ? (degrees_ ? kDegree * q(row, i) : q(row, i)) : 0.0;
      frames.push_back(chain_.frames(angles));
    }
    for (const Spheres& spheres : bodies_) {
      Points centers(q.rows() * std::ssize(spheres.all), 3);
      Eigen::Index at = 0;
      for (const auto& poses : frames) {
        for (const BodySphere& sphere : spheres.all) {
          const FramePose<double>& pose = poses[static_cast<std::size_t>(sphere.frame)];
          const std::array<double, 3> turned = pose.turned(sphere.center);
          for (std::size_t i = 0; i < 3; ++i)
            centers(at, static_cast<Eigen::Index>(i)) = pose.origin[i] + turned[i];
          ++at;
        }
      }
      const Vector levels = spheres.grown->level(centers);
      at = 0;
      for (Eigen::Index row = 0; row < q.rows(); ++row) {
        for (const double scale : spheres.scales) {
          const double one = levels[at++] / scale;
          if (one < level[row]) level[row] = one;  // and NaN stays
        }
      }
    }
  }

  KinematicChain chain_;
  std::vector<Spheres> bodies_;
  bool degrees_;
  std::string text_;
};

// Of the angles in `reach`: at least the root of the sum of its squares, and not next to 0 where a ball hardly moves.
double scale_of(const std::vector<double>& reach, double largest) {
  Interval squares = 0.0;
  for (const double r : reach) squares += square(Interval(r));
  return std::max(sqrt(squares).upper, 1e-3 * largest);
}

bool has_arm(const RegionOptions& region) {
  return region.type == "arm" || std::any_of(region.of.begin(), region.of.end(), has_arm);
}

// The obstacles, each grown by `radius`, as one.
RegionPtr grown_obstacle(const RegionOptions& options, double radius, RegionFiles& files) {
  std::vector<RegionPtr> grown;
  for (std::size_t i = 0; i < options.obstacles.size(); ++i) {
    RegionOptions one = options.obstacles[i];
    one.inflate = next_up(one.inflate + radius);
    grown.push_back(make_region(one, 3, files, fmt::format("obstacles[{}]", i)));
  }
  return grown.size() == 1 ? grown.front() : unite(std::move(grown));
}

KinematicChain chain_of(const RegionOptions& options) {
  Vector base = Vector::Zero(3);
  if (!options.base.empty()) base = Eigen::Map<const Vector>(options.base.data(), std::ssize(options.base));
  return {options.dh, options.convention == "standard" ? DhConvention::standard : DhConvention::modified,
          base, options.rotation.empty() ? no_rotation(3) : rotation_in_space(options.rotation)};
}

double least_radius(const std::vector<BodySphere>& spheres) {
  double least = kInfinity;
  for (const BodySphere& sphere : spheres) least = std::min(least, sphere.radius);
  return least;
}

// Spheres by their radius, with the obstacle grown by it, of which `grown` is that of the least radius.
class Grouping {
 public:
  Grouping(const RegionOptions& options, RegionPtr grown, double least, RegionFiles& files)
      : options_(options), grown_(std::move(grown)), least_(least), files_(files) {}

  Spheres& group_of(double radius) {
    for (Spheres& group : groups_) {
      if (group.all.front().radius == radius) return group;
    }
    return groups_.emplace_back(Spheres{obstacle(radius), {}, {}, {}});
  }
  std::vector<Spheres> take() { return std::move(groups_); }

 private:
  RegionPtr obstacle(double radius) {
    if (radius == least_) return grown_;
    // Growing twice what is no distance takes long.
    return grown_->is_lipschitz() ? inflated(grown_, next_up(radius - least_))
                                  : grown_obstacle(options_, radius, files_);
  }

  const RegionOptions& options_;
  RegionPtr grown_;
  double least_;
  RegionFiles& files_;
  std::vector<Spheres> groups_;
};

// How far each sphere moves, at most, with each joint's unit.
std::vector<std::vector<double>> reaches_of(const KinematicChain& chain,
                                            const std::vector<BodySphere>& spheres, bool degrees) {
  std::vector<std::vector<double>> reaches;
  for (const BodySphere& sphere : spheres) {
    reaches.push_back(chain.reaches(sphere.frame, sphere.center));
    if (!degrees) continue;
    for (double& reach : reaches.back())
      reach = (Interval(reach) * pi_interval() / Interval(180.0)).magnitude();
  }
  return reaches;
}

RegionPtr make_arm(const RegionOptions& options, RegionFiles& files) {
  KinematicChain chain = chain_of(options);
  const std::vector<BodySphere> spheres =
      cover_bodies({options.radius, options.tip, options.spheres, options.capsules}, chain);
  const bool degrees = options.joint_unit == "deg";
  const auto reaches = reaches_of(chain, spheres, degrees);
  double farthest = 0.0, greatest = 0.0;
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    farthest = std::max(farthest, *std::max_element(reaches[k].begin(), reaches[k].end()));
    greatest = std::max(greatest, spheres[k].radius);
  }
  const double least = least_radius(spheres);
  const RegionPtr grown = grown_obstacle(options, least, files);
  Grouping grouping(options, grown, least, files);
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    Spheres& group = grouping.group_of(spheres[k].radius);
    group.all.push_back(spheres[k]);
    group.reaches.push_back(reaches[k]);
    group.scales.push_back(scale_of(reaches[k], farthest));
  }
  const std::string radii =
      least < greatest ? fmt::format("{:.4g} to {:.4g}", least, greatest) : fmt::format("{:.4g}", least);
  return std::make_shared<ArmRegion>(
      std::move(chain), grouping.take(), degrees,
      fmt::format("arm of {} joints ({} DH), {} spheres of radius {}; centres of the smallest in [{}]",
                  options.dh.size(), options.convention, spheres.size(), radii, grown->describe()));
}

}  // namespace

RegionPtr arm_region(const RegionOptions& options, Eigen::Index dimension, RegionFiles& files) {
  try {
    check(std::ssize(options.dh) == dimension,
          "dh has {} rows [a, alpha, d, theta], expected {}, one a joint", options.dh.size(), dimension);
    const bool nested = std::any_of(options.obstacles.begin(), options.obstacles.end(), has_arm);
    check(!options.obstacles.empty() && !nested,
          "found {}, expected one region in space or more as obstacles",
          nested ? "an arm as an obstacle" : "no obstacles");
    return make_arm(options, files);
  } catch (const Error& error) {
    fail("arm: {}", error.what());
  }
}

}  // namespace s2nnds
