// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/grid_level.h"

#include <cmath>

namespace s2nnds {
namespace {

std::vector<Vector> axes_of(const Vector& half, Eigen::Index side) {
  std::vector<Vector> axes;
  for (const double length : half) axes.push_back(Vector::LinSpaced(side, -length, length));
  return axes;
}

// Whether a point of the grid next to this one, by faces or corners, lies in the set.
bool has_neighbour(const std::vector<Vector>& axes, Eigen::Index point, const Vector& level) {
  const auto n = static_cast<Eigen::Index>(axes.size());
  const auto all = static_cast<Eigen::Index>(std::pow(3.0, n));
  for (Eigen::Index k = 0; k < all; ++k) {
    Eigen::Index steps = k, rest = point, stride = 1, next = 0;
    bool within = true;
    for (Eigen::Index i = n; i-- > 0; steps /= 3) {
      const Eigen::Index size = axes[static_cast<std::size_t>(i)].size();
      const Eigen::Index place = rest % size + steps % 3 - 1;
      within = within && place >= 0 && place < size;
      next += place * stride;
      rest /= size;
      stride *= size;
    }
    if (within && level[next] <= 0.0) return true;
  }
  return false;
}

}  // namespace

Points grid_points(const std::vector<Vector>& axes) {
  Eigen::Index total = 1;
  for (const Vector& axis : axes) total *= axis.size();
  Points x(total, static_cast<Eigen::Index>(axes.size()));
  for (Eigen::Index i = 0; i < total; ++i) {
    Eigen::Index rest = i;
    for (Eigen::Index k = x.cols(); k-- > 0;) {
      const Vector& axis = axes[static_cast<std::size_t>(k)];
      x(i, k) = axis[rest % axis.size()];
      rest /= axis.size();
    }
  }
  return x;
}

Vector grid_level(const Region& region, const std::vector<Vector>& axes) {
  const Points points = grid_points(axes);
  const Vector level = region.level(points);
  Vector half(points.cols());
  for (Eigen::Index i = 0; i < half.size(); ++i) {
    const Vector& axis = axes[static_cast<std::size_t>(i)];
    half[i] = axis.size() > 1 ? 0.5 * (axis[1] - axis[0]) : 0.0;
  }
  const Points cell = grid_points(axes_of(half, points.cols() > 2 ? 5 : 9));
  Vector shown = level;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const bool far = region.is_lipschitz() && level[i] > half.norm();
    if (level[i] <= 0.0 || far || has_neighbour(axes, i, level)) continue;
    const Vector middle = points.row(i).transpose();
    if (region.classify({middle - half, middle + half}) == Location::outside) continue;
    const double least = region.level(cell.rowwise() + points.row(i)).minCoeff();
    if (least <= 0.0) shown[i] = least;
  }
  return shown;
}

}  // namespace s2nnds
