// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/kinematic_chain.h"

#include <cmath>
#include <type_traits>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// Entries of a rotation matrix are cosines.
void keep_cosine(Interval& entry) {
  entry.lower = std::max(entry.lower, -1.0);
  entry.upper = std::min(entry.upper, 1.0);
}
void keep_cosine(double&) {}

// Turns axis `from` towards the one after it.
template <typename Number>
void turn(FramePose<Number>& pose, std::size_t from, const Number& cosine, const Number& sine) {
  for (std::size_t i = 0; i < 3; ++i) {
    Number &first = pose.axes[3 * i + from], &second = pose.axes[3 * i + from + 1];
    const Number before = first;
    first = cosine * before + sine * second;
    second = cosine * second - sine * before;
    keep_cosine(first);
    keep_cosine(second);
  }
}

template <typename Number>
void turn_about_z(FramePose<Number>& pose, const Number& angle) {
  using std::cos, std::sin;
  turn(pose, 0, Number(cos(angle)), Number(sin(angle)));
}

template <typename Number>
void shift(FramePose<Number>& pose, const Eigen::Vector3d& by) {
  const std::array<Number, 3> step = pose.turned(by);
  for (std::size_t i = 0; i < 3; ++i) {
    pose.step[i] += step[i];
    pose.origin[i] += step[i];
  }
}

double upper(const Interval& x) { return x.magnitude(); }

// At least the root of x^2 + y^2, exactly 0 for 0.
double norm_bound(double x, double y) {
  return x == 0.0 && y == 0.0 ? 0.0 : sqrt(square(Interval(x)) + square(Interval(y))).upper;
}

}  // namespace

template <typename Number>
std::array<Number, 3> FramePose<Number>::turned(const Eigen::Vector3d& at) const {
  std::array<Number, 3> result = {};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double by = at[static_cast<Eigen::Index>(j)];
      if (by != 0.0) result[i] += axes[3 * i + j] * Number(by);
    }
  }
  return result;
}

KinematicChain::KinematicChain(const std::vector<std::vector<double>>& rows, DhConvention convention,
                               const Vector& base, const Rotation& rotation)
    : convention_(convention), rotation_(rotation) {
  check(!rows.empty(), "dh: found no rows, expected one a joint: [a, alpha, d, theta]");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    check(rows[i].size() == 4, "dh[{}]: found {} numbers, expected 4: a, alpha, d, theta", i, rows[i].size());
    for (const double number : rows[i]) {
      check(std::isfinite(number), "dh[{}]: found {}, expected a finite number", i, number);
    }
    const double alpha = rows[i][1];
    // Also exactly: sines of 0 are 0.
    const Interval c = alpha == 0.0 ? Interval(1.0) : cos(Interval(alpha));
    const Interval s = alpha == 0.0 ? Interval(0.0) : sin(Interval(alpha));
    links_.push_back({rows[i][0], rows[i][2], rows[i][3], std::cos(alpha), std::sin(alpha), c, s});
  }
  check(base.size() == 3 && base.allFinite() && rotation.matrix.rows() == 3,
        "base: found {} numbers, expected 3 that are finite", base.size());
  base_ = base;
}

template <typename Number>
std::pair<Number, Number> KinematicChain::twist(const Link& link) {
  if constexpr (std::is_same_v<Number, double>) {
    return {link.cos_alpha, link.sin_alpha};
  } else {
    return {link.exact_cos, link.exact_sin};
  }
}

template <typename Number>
std::vector<FramePose<Number>> KinematicChain::frames(const std::vector<Number>& angles) const {
  check(angles.size() == links_.size(), "arm: found {} joint angles, expected {}", angles.size(),
        links_.size());
  std::vector<FramePose<Number>> poses;
  poses.reserve(links_.size() + 1);
  FramePose<Number> pose = {};
  for (std::size_t i = 0; i < 9; ++i) {
    if constexpr (std::is_same_v<Number, double>) {
      pose.axes[i] = rotation_.matrix.data()[i];
    } else {
      pose.axes[i] = rotation_.enclosure[i];
    }
  }
  for (std::size_t i = 0; i < 3; ++i) pose.origin[i] = base_[static_cast<Eigen::Index>(i)];
  poses.push_back(pose);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    const Number angle = angles[i] + Number(link.theta);
    const auto [cosine, sine] = twist<Number>(link);
    pose.step = {};
    if (convention_ == DhConvention::modified) {
      shift(pose, {link.a, 0.0, 0.0});
      turn(pose, 1, cosine, sine);
      shift(pose, {0.0, 0.0, link.d});
      turn_about_z(pose, angle);
    } else {
      turn_about_z(pose, angle);
      shift(pose, {link.a, 0.0, link.d});
      turn(pose, 1, cosine, sine);
    }
    poses.push_back(pose);
  }
  return poses;
}

Eigen::Index KinematicChain::axis_of(Eigen::Index joint) const {
  return convention_ == DhConvention::modified ? joint : joint - 1;
}

FrameSegment KinematicChain::link(Eigen::Index i) const {
  const Link& link = links_[static_cast<std::size_t>(i - 1)];
  const Eigen::Vector3d to(link.a, -link.sin_alpha * link.d, link.cos_alpha * link.d), none(0.0, 0.0, 0.0);
  if (convention_ == DhConvention::modified) return {i - 1, none, to};
  if (link.a == 0.0) return {i - 1, none, {0.0, 0.0, link.d}};
  return {i, {-link.a, -link.sin_alpha * link.d, -link.cos_alpha * link.d}, none};
}

std::vector<double> KinematicChain::reaches(Eigen::Index frame, const Eigen::Vector3d& at) const {
  std::vector<double> reach(links_.size(), 0.0);
  // Of the point as seen from the frame: its distance from the z axis, and how far it is along that, both at most.
  double aside = norm_bound(at[0], at[1]), along = std::abs(at[2]);
  // From what a row turns and moves by to the frame before.
  const auto step_back = [&](const Link& link) {
    const Interval moved = Interval(along) + Interval(std::abs(link.d));
    // Turned about x after d in the modified convention, before it in the standard one.
    const double z = convention_ == DhConvention::modified ? upper(moved) : along;
    const double sine = upper(link.exact_sin), cosine = upper(link.exact_cos);
    const double far = norm_bound(aside, z);
    const double next = std::min(far, upper(Interval(aside) + Interval(sine) * Interval(z)));
    along = std::min(far, upper(Interval(sine) * Interval(aside) + Interval(cosine) * Interval(z)));
    if (convention_ == DhConvention::standard) along = upper(Interval(along) + Interval(std::abs(link.d)));
    aside = upper(Interval(next) + Interval(std::abs(link.a)));
  };
  for (Eigen::Index i = frame; i >= 1; --i) {
    const auto k = static_cast<std::size_t>(i - 1);
    if (convention_ == DhConvention::standard) step_back(links_[k]);
    reach[k] = aside;
    if (convention_ == DhConvention::modified) step_back(links_[k]);
  }
  return reach;
}

template struct FramePose<double>;
template struct FramePose<Interval>;
template std::vector<FramePose<double>> KinematicChain::frames(const std::vector<double>&) const;
template std::vector<FramePose<Interval>> KinematicChain::frames(const std::vector<Interval>&) const;

}  // namespace s2nnds
