// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/handwriting.h"

#include <fmt/ranges.h>

#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/math/differentiation/autodiff.hpp>
#include <cmath>
#include <cstdint>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

constexpr double kPi = boost::math::constants::pi<double>();
constexpr std::uint64_t kSeed = 2024;
constexpr int kDemonstrations = 7;
constexpr Eigen::Index kSamples = 1000;

// A value and its derivative with respect to the path parameter s in [0, 1].
using Dual = boost::math::differentiation::autodiff_v1::detail::fvar<double, 1>;
using Place = std::array<Dual, 3>;  // the third coordinate counts in 3-D motions only

// Two humps from left to right, mm.
Place sine(const Dual& s) { return {45.0 * s, 12.0 * sin(2 * kPi * s), 0.0}; }

// From the upper right through two opposite bows to the lower left.
Place s_curve(const Dual& s) {
  const Dual r = 2.0 * s - 1.0;
  return {17.0 * sin(1.3 * kPi * r), -21.0 * (r - 0.12 * sin(2 * kPi * r)), 0.0};
}

// An arc of 240 degrees, from the upper right over the left to the lower right, a little higher than wide.
Place c_curve(const Dual& s) {
  const Dual angle = kPi * (1.0 / 3 + 4.0 / 3 * s);
  return {18.0 * cos(angle), 22.0 * sin(angle), 0.0};
}

// Up, down along the diagonal, up again: most of the way to the right falls to the middle stroke.
Place n_curve(const Dual& s) {
  const Dual phase = kPi * (0.15 + 2.7 * s);
  return {42.0 * (s - 0.7 / (2 * kPi) * sin(2 * kPi * s)), -22.0 * cos(phase), 0.0};
}

// One and a half turns inwards, the radius shrinking in proportion.
Place spiral(const Dual& s) {
  const Dual radius = 42.0 * (1.0 - s);
  const Dual angle = 3.0 * kPi * s;
  return {radius * cos(angle), radius * sin(angle), 0.0};
}

// One and a quarter turns downwards on a cylinder.
Place helix(const Dual& s) {
  const Dual angle = 2.5 * kPi * s;
  return {20.0 * cos(angle), 20.0 * sin(angle), -45.0 * s};
}

struct Motion {
  const char* name;
  Place (*path)(const Dual& s);
  Eigen::Index dimension;
  double duration;  // s
};

constexpr std::array<Motion, 6> kMotions = {{{"Sine", sine, 2, 5.0},
                                             {"S", s_curve, 2, 5.0},
                                             {"C", c_curve, 2, 4.0},
                                             {"N", n_curve, 2, 5.0},
                                             {"Spiral", spiral, 2, 6.0},
                                             {"Helix", helix, 3, 6.0}}};

const Motion& find_motion(const std::string& name) {
  for (const Motion& motion : kMotions) {
    if (motion.name == name) return motion;
  }
  fail("handwriting: found motion '{}'; expected one of {}", name, fmt::join(handwriting_motions(), ", "));
}

// How one demonstration strays from the path along one axis: (1 - s) (a + b cos(pi s) + c cos(2 pi s)), in
// mm.
class Deviation {
 public:
  Deviation(RandomStream& random, double size)
      : a_(size * random.normal()), b_(0.5 * size * random.normal()), c_(0.25 * size * random.normal()) {}

  Dual operator()(const Dual& s) const {
    return (1.0 - s) * (a_ + b_ * cos(kPi * s) + c_ * cos(2 * kPi * s));
  }

 private:
  double a_, b_, c_;
};

Demonstration demonstrate(const Motion& motion, RandomStream random) {
  const double size = 45.0;  // mm, of all the motions
  const double duration = motion.duration * (1.0 + 0.04 * random.normal());
  std::vector<Deviation> deviations;
  for (Eigen::Index axis = 0; axis < motion.dimension; ++axis) deviations.emplace_back(random, 0.04 * size);
  const Place goal = motion.path(Dual(1.0));
  Demonstration d{Vector(kSamples), Points(kSamples, motion.dimension), Points(kSamples, motion.dimension)};
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    const double u = static_cast<double>(i) / (kSamples - 1);
    const Dual s = boost::math::differentiation::make_fvar<double, 1>(u * u * u * (10 + u * (6 * u - 15)));
    const double s_rate = 30 * u * u * (1 - u) * (1 - u) / duration;  // ds/dt, 1/s
    const Place place = motion.path(s);
    d.time[i] = u * duration;
    for (Eigen::Index axis = 0; axis < motion.dimension; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      const Dual x = place[k] - goal[k] + deviations[k](s);
      d.position(i, axis) = x.derivative(0);
      d.velocity(i, axis) = x.derivative(1) * s_rate;
    }
  }
  return d;
}

}  // namespace

std::vector<std::string> handwriting_motions() {
  std::vector<std::string> names;
  for (const Motion& motion : kMotions) names.emplace_back(motion.name);
  return names;
}

DemonstrationSet handwriting(const std::string& name) {
  const Motion& motion = find_motion(name);
  DemonstrationSet set{name, "mm", {}};
  for (std::uint64_t k = 0; k < kDemonstrations; ++k) {
    set.demonstrations.push_back(demonstrate(motion, RandomStream(kSeed, "handwriting/" + name, k)));
  }
  return set;
}

}  // namespace s2nnds
