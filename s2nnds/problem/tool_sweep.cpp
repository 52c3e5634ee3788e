// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/tool_sweep.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr int kMostParts = 6;  // of the axis; each makes a copy of the obstacle
// Covers rounding, relative to the largest number that it touches.
constexpr double kRounding = 1e-12;

struct Sweep {
  Eigen::Vector3d center;  // from the position, in the data's frame
  double radius;
};

Eigen::Vector3d point(const std::vector<double>& numbers, const char* key) {
  check(numbers.size() == 3, "problem.tool.{}: found {} numbers, expected 3", key, numbers.size());
  const Eigen::Vector3d x(numbers[0], numbers[1], numbers[2]);
  check(x.allFinite(), "problem.tool.{}: found ({}), expected finite numbers", key, fmt::join(numbers, ", "));
  return x;
}

std::vector<Sweep> sweeps_of(const ToolOptions& tool, const Eigen::Matrix3d& goal) {
  const Eigen::Vector3d a = point(tool.start, "start"), b = point(tool.end, "end");
  // Convex sets reach farthest at an end.
  if (tool.turn == 0.0) return {{Eigen::Vector3d::Zero(), std::max(a.norm(), b.norm()) + tool.radius}};
  const double length = (b - a).norm(), angle = tool.turn * (M_PI / 180.0);
  const double wanted = std::ceil(length / std::max(2.0 * tool.radius, length / kMostParts));
  const int parts = std::clamp(std::isfinite(wanted) ? static_cast<int>(wanted) : 1, 1, kMostParts);
  std::vector<Sweep> sweeps;
  for (int i = 0; i < parts; ++i) {
    const Eigen::Vector3d middle = a + (i + 0.5) / parts * (b - a);
    sweeps.push_back({goal * (std::cos(angle) * middle),
                      std::sin(angle) * middle.norm() + 0.5 * length / parts + tool.radius});
  }
  return sweeps;
}

// Moves what is written of a region.
class Mover {
 public:
  explicit Mover(const Eigen::Vector3d& by) : by_(by), largest_(by.cwiseAbs().maxCoeff()) {}

  void move(RegionOptions& region) {
    const std::string& type = region.type;
    if (type == "ball" || type == "ellipsoid" || type == "oriented_box") {
      move(region.center);
    } else if (type == "mesh" || type == "point_cloud") {
      if (region.center.empty()) region.center = {0.0, 0.0, 0.0};
      move(region.center);
    } else if (type == "box") {
      move(region.lower);
      move(region.upper);
    } else if (type == "capsule" || type == "cylinder") {
      move(region.start);
      move(region.end);
    } else if (type == "polytope") {
      for (std::vector<double>& vertex : region.vertices) move(vertex);
      for (std::size_t i = 0; i < std::min(region.normals.size(), region.offsets.size()); ++i)
        move(region.normals[i], region.offsets[i]);
    } else if (type == "halfspace") {
      move(region.normal, region.offset);
    } else if (type == "union" || type == "intersection" || type == "complement") {
      for (RegionOptions& part : region.of) move(part);
    } else {
      check(type == "none",
            "problem.tool: found an unsafe set of type \"{}\", expected one that has a place: ball, box, "
            "ellipsoid, oriented_box, capsule, cylinder, polytope, mesh, point_cloud, halfspace or sets of "
            "these",
            type);
    }
  }
  double largest() const { return largest_; }  // number that took part

 private:
  // A point; what has another number of coordinates is refused where the region is made.
  void move(std::vector<double>& place) {
    for (std::size_t d = 0; d < std::min<std::size_t>(place.size(), 3); ++d) {
      if (std::isfinite(place[d])) largest_ = std::max(largest_, std::abs(place[d]));
      place[d] += by_[static_cast<Eigen::Index>(d)];
    }
  }
  // normal . x <= offset
  void move(const std::vector<double>& normal, double& offset) {
    if (normal.size() != 3) return;
    const Eigen::Vector3d n(normal[0], normal[1], normal[2]);
    if (n.norm() > 0.0) largest_ = std::max(largest_, std::abs(offset) / n.norm());
    offset += n.dot(by_);
  }

  Eigen::Vector3d by_;
  double largest_;
};

}  // namespace

void ToolOptions::visit(FieldVisitor& v) {
  v.field("start", start, any_number());
  v.field("end", end, any_number());
  v.field("radius", radius, at_least(0.0));
  v.field("turn", turn, {.low = 0.0, .high = 90.0, .open_high = true});
}

RegionOptions swept(const RegionOptions& obstacle, const ToolOptions& tool, const Eigen::Matrix3d& goal) {
  RegionOptions all{.type = "union"};
  for (const Sweep& sweep : sweeps_of(tool, goal)) {
    Mover mover(-sweep.center);
    RegionOptions copy = obstacle;
    mover.move(copy);
    copy.inflate += sweep.radius + kRounding * (mover.largest() + sweep.radius + obstacle.inflate);
    all.of.push_back(std::move(copy));
  }
  return all.of.size() == 1 ? all.of.front() : all;
}

std::string in_words(const ToolOptions& tool, const std::string& unit) {
  return fmt::format("a capsule from ({:.6g}) to ({:.6g}) of radius {:.6g}{}", fmt::join(tool.start, ", "),
                     fmt::join(tool.end, ", "), tool.radius, unit.empty() ? "" : " " + unit);
}

}  // namespace s2nnds
