// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/polytope.h"

#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/polygon.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kMostVertices = 200;  // every three of them are looked at
constexpr Eigen::Index kMostListed = 16;     // vertices in describe()
constexpr double kFlat = 1e-9;               // of the hull's size: points so near to a plane count as on it

std::string text(const Eigen::Ref<const Eigen::RowVectorXd>& x) {
  return fmt::format("({})", fmt::join(x.data(), x.data() + x.size(), ", "));
}

class Polytope final : public Region {
 public:
  Polytope(std::vector<RegionPtr> halfspaces, std::string text)
      : set_(intersect(std::move(halfspaces))), text_(std::move(text)) {}
  Eigen::Index dimension() const override { return set_->dimension(); }
  bool is_lipschitz() const override { return true; }
  std::string describe() const override { return text_; }

 protected:
  void evaluate(const Points& x, Vector& level) const override { level = set_->level(x); }
  Interval enclose(const Box& box) const override { return set_->enclosure(box); }

 private:
  RegionPtr set_;
  std::string text_;
};

// At least normal . v for every vertex.
double support(const Eigen::RowVector3d& normal, const Points& vertices) {
  double greatest = -std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < vertices.rows(); ++k) {
    Interval sum = 0.0;
    for (Eigen::Index i = 0; i < 3; ++i) sum += Interval(normal[i]) * vertices(k, i);
    greatest = std::max(greatest, sum.upper);
  }
  return greatest;
}

// The unit normals of the planes through three vertices with all others on one side: [faces, 3].
std::vector<Eigen::RowVector3d> face_normals(const Points& vertices, double size) {
  std::vector<Eigen::RowVector3d> normals;
  const auto point = [&](Eigen::Index k) -> Eigen::RowVector3d { return vertices.row(k); };
  const auto keep = [&](const Eigen::RowVector3d& normal, Eigen::Index on) {
    if ((vertices * normal.transpose()).maxCoeff() > point(on).dot(normal) + kFlat * size) return;
    const bool known = std::any_of(normals.begin(), normals.end(), [&](const Eigen::RowVector3d& other) {
      return (other - normal).norm() < kFlat;
    });
    if (!known) normals.push_back(normal);
  };
  for (Eigen::Index i = 0; i < vertices.rows(); ++i) {
    for (Eigen::Index j = i + 1; j < vertices.rows(); ++j) {
      for (Eigen::Index k = j + 1; k < vertices.rows(); ++k) {
        const Eigen::RowVector3d across = (point(j) - point(i)).cross(point(k) - point(i));
        if (!(across.norm() > kFlat * size * size)) continue;
        keep(across.normalized(), i);
        keep(-across.normalized(), i);
      }
    }
  }
  return normals;
}

// The corners of the hull in the plane, by the monotone chain of points sorted by x, then y.
Points hull_corners(const Points& vertices) {
  std::vector<Eigen::RowVector2d> sorted;
  for (Eigen::Index k = 0; k < vertices.rows(); ++k) sorted.emplace_back(vertices.row(k));
  const auto before = [](const Eigen::RowVector2d& a, const Eigen::RowVector2d& b) {
    return a[0] < b[0] || (a[0] == b[0] && a[1] < b[1]);
  };
  std::sort(sorted.begin(), sorted.end(), before);
  std::vector<Eigen::RowVector2d> hull;
  const auto turns_right = [&](const Eigen::RowVector2d& to) {
    const Eigen::RowVector2d& a = hull[hull.size() - 2];
    const Eigen::RowVector2d& b = hull.back();
    const Interval turn = (Interval(b[0]) - a[0]) * (Interval(to[1]) - a[1]) -
                          (Interval(b[1]) - a[1]) * (Interval(to[0]) - a[0]);
    return !(turn.lower > 0.0);
  };
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t least = hull.size() + 1;
    for (const Eigen::RowVector2d& to : sorted) {
      while (hull.size() > least && turns_right(to)) hull.pop_back();
      if (hull.empty() || hull.back() != to) hull.push_back(to);
    }
    hull.pop_back();  // the next pass begins with it
    std::reverse(sorted.begin(), sorted.end());
  }
  Points corners(static_cast<Eigen::Index>(hull.size()), 2);
  for (std::size_t k = 0; k < hull.size(); ++k) corners.row(static_cast<Eigen::Index>(k)) = hull[k];
  return corners;
}

}  // namespace

RegionPtr polytope(const Points& normals, const Vector& offsets) {
  check(normals.rows() > 0 && normals.rows() == offsets.size(),
        "polytope: found {} normals and {} offsets, expected as many of both, at least one", normals.rows(),
        offsets.size());
  std::vector<RegionPtr> halfspaces;
  std::string described = "polytope";
  for (Eigen::Index k = 0; k < normals.rows(); ++k) {
    halfspaces.push_back(halfspace(normals.row(k).transpose(), offsets[k]));
    described += fmt::format("{} {} . x <= {}", k > 0 ? "," : "", text(normals.row(k)), offsets[k]);
  }
  return std::make_shared<Polytope>(std::move(halfspaces), described);
}

RegionPtr convex_hull(const Points& vertices) {
  check((vertices.cols() == 2 || vertices.cols() == 3) && vertices.rows() > vertices.cols() &&
            vertices.rows() <= kMostVertices && vertices.allFinite(),
        "polytope: found {} vertices of {} coordinates, expected {} to {} finite ones of 2 or 3",
        vertices.rows(), vertices.cols(), vertices.cols() + 1, kMostVertices);
  const double size = (vertices.colwise().maxCoeff() - vertices.colwise().minCoeff()).maxCoeff();
  const auto flat = [&] {
    fail("polytope: the {} vertices lie on one {}, expected a hull with a volume", vertices.rows(),
         vertices.cols() == 2 ? "line" : "plane");
  };
  if (vertices.cols() == 2) {
    const Points corners = hull_corners(vertices);
    if (corners.rows() < 3) flat();
    return polygon(corners);
  }
  const std::vector<Eigen::RowVector3d> normals = face_normals(vertices, size);
  std::vector<RegionPtr> halfspaces;
  for (const Eigen::RowVector3d& normal : normals) {
    const double greatest = support(normal, vertices);
    if (greatest - (vertices * normal.transpose()).minCoeff() <= kFlat * size) flat();
    halfspaces.push_back(halfspace(normal.transpose(), greatest));
  }
  if (halfspaces.size() < 4) flat();
  std::string described = fmt::format("polytope of {} faces with the vertices", halfspaces.size());
  for (Eigen::Index k = 0; k < std::min(vertices.rows(), kMostListed); ++k)
    described += " " + text(vertices.row(k));
  if (vertices.rows() > kMostListed) described += fmt::format(" and {} more", vertices.rows() - kMostListed);
  return std::make_shared<Polytope>(std::move(halfspaces), described);
}

}  // namespace s2nnds
