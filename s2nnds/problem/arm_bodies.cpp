// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/arm_bodies.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr double kSpacing = 0.8;  // of a capsule's spheres, as a share of its radius
constexpr int kMostSpheres = 64;  // of a capsule
constexpr double kRounding = 1e-12;

// The spheres between the ends of a capsule, both included, and the radius that they need.
struct Cover {
  std::vector<Eigen::Vector3d> centers;
  double radius;
};

Cover cover(const FrameSegment& axis, double radius) {
  const Eigen::Vector3d along = axis.end - axis.start;
  const double length = along.norm();
  const int parts =
      static_cast<int>(std::clamp(std::ceil(length / (kSpacing * radius)), 0.0, double{kMostSpheres}));
  if (parts == 0) return {{axis.start}, radius};
  Cover result;
  for (int i = 0; i <= parts; ++i)
    result.centers.emplace_back(i == parts ? axis.end : axis.start + i * along / parts);
  const double largest = axis.start.norm() + axis.end.norm();
  result.radius = std::hypot(radius, 0.5 * length / parts) * (1.0 + kRounding) + kRounding * largest;
  return result;
}

// A row as it was written, checked: its frame and the numbers after it.
struct Row {
  Eigen::Index frame;
  std::vector<double> numbers;

  Eigen::Vector3d point(std::size_t from) const {
    return {numbers[from], numbers[from + 1], numbers[from + 2]};
  }
};

Row read_row(const std::vector<double>& row, const std::string& name, const char* columns, std::size_t count,
             Eigen::Index joints) {
  check(row.size() == count, "{}: found {} numbers, expected {}: {}", name, row.size(), count, columns);
  for (const double number : row) {
    check(std::isfinite(number), "{}: found ({}), expected finite numbers", name, fmt::join(row, ", "));
  }
  check(row[0] == std::floor(row[0]) && row[0] >= 0.0 && row[0] <= static_cast<double>(joints),
        "{}: found frame {}, expected one of 0 (the base) to {}", name, row[0], joints);
  check(row.back() > 0.0, "{}: found radius {}, expected > 0", name, row.back());
  return {static_cast<Eigen::Index>(row[0]), {row.begin() + 1, row.end()}};
}

class Builder {
 public:
  explicit Builder(const KinematicChain& chain) : chain_(chain) {}

  void add(Eigen::Index frame, const Eigen::Vector3d& center, double radius) {
    const std::vector<double> reach = chain_.reaches(frame, center);
    if (std::any_of(reach.begin(), reach.end(), [](double r) { return r != 0.0; }))
      spheres_.push_back({frame, center, radius});
  }
  void add(const FrameSegment& axis, double radius) {
    const Cover covered = cover(axis, radius);
    for (const Eigen::Vector3d& center : covered.centers) add(axis.frame, center, covered.radius);
  }
  // Capsules that meet at the frames' origins, where one sphere, the larger, does for both.
  void add_links(const std::vector<FrameSegment>& links, double radius) {
    double before = radius;
    for (std::size_t i = 0; i < links.size(); ++i) {
      const Cover covered = cover(links[i], radius);
      const auto origin = static_cast<Eigen::Index>(i);
      if (covered.centers.size() == 1) continue;
      add(origin, Eigen::Vector3d::Zero(), std::max(before, covered.radius));
      for (std::size_t k = 1; k + 1 < covered.centers.size(); ++k)
        add(links[i].frame, covered.centers[k], covered.radius);
      before = covered.radius;
      last_ = {links[i].frame, covered.centers.back(), covered.radius};
    }
    if (last_.radius > 0.0) add(last_.frame, last_.center, last_.radius);
  }
  const std::vector<BodySphere>& spheres() const { return spheres_; }

 private:
  const KinematicChain& chain_;
  std::vector<BodySphere> spheres_;
  BodySphere last_;
};

}  // namespace

std::vector<BodySphere> cover_bodies(const ArmBodies& bodies, const KinematicChain& chain) {
  const Eigen::Index joints = chain.joints();
  check(bodies.radius > 0.0 || !bodies.spheres.empty() || !bodies.capsules.empty(),
        "found no bodies, expected radius (of all links), spheres or capsules");
  check(std::isfinite(bodies.radius), "radius: found {}, expected a finite number", bodies.radius);
  Builder builder(chain);
  if (bodies.radius > 0.0) {
    std::vector<FrameSegment> links;
    for (Eigen::Index i = 1; i <= joints; ++i) links.push_back(chain.link(i));
    if (!bodies.tip.empty()) {
      check(bodies.tip.size() == 3, "tip: found {} numbers, expected 3", bodies.tip.size());
      const Eigen::Vector3d tip(bodies.tip.data());
      check(tip.allFinite(), "tip: found ({}), expected finite numbers", fmt::join(bodies.tip, ", "));
      links.push_back({joints, Eigen::Vector3d::Zero(), tip});
    }
    builder.add_links(links, bodies.radius);
  }
  for (std::size_t i = 0; i < bodies.spheres.size(); ++i) {
    const Row row =
        read_row(bodies.spheres[i], fmt::format("spheres[{}]", i), "frame, x, y, z, radius", 5, joints);
    builder.add(row.frame, row.point(0), row.numbers.back());
  }
  for (std::size_t i = 0; i < bodies.capsules.size(); ++i) {
    const Row row = read_row(bodies.capsules[i], fmt::format("capsules[{}]", i),
                             "frame, x, y, z, x, y, z, radius", 8, joints);
    builder.add({row.frame, row.point(0), row.point(3)}, row.numbers.back());
  }
  check(!builder.spheres().empty(), "found no body that a joint moves, expected one");
  return builder.spheres();
}

}  // namespace s2nnds
