// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/boundary_points.h"

#include <cmath>
#include <vector>

#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

constexpr int kBisections = 40;
constexpr double kDifference = 1e-5;  // step of the central differences

// Bisects the segments from points of the region to points outside of it.
Points crossings(const Region& region, Points inside, Points outside) {
  for (int k = 0; k < kBisections; ++k) {
    const Points middle = 0.5 * (inside + outside);
    const Vector level = region.level(middle);
    for (Eigen::Index i = 0; i < middle.rows(); ++i)
      (level[i] <= 0.0 ? inside : outside).row(i) = middle.row(i);
  }
  return outside;
}

Points slopes(const Region& region, const Points& x) {
  Points slope(x.rows(), x.cols());
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    Points ahead = x, behind = x;
    ahead.col(k).array() += kDifference;
    behind.col(k).array() -= kDifference;
    slope.col(k) = (region.level(ahead) - region.level(behind)) / (2.0 * kDifference);
  }
  return slope;
}

// The rows for which `keep` says so.
template <typename Keep>
std::vector<Eigen::Index> rows_where(Eigen::Index count, Keep keep) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (keep(i)) rows.push_back(i);
  }
  return rows;
}

}  // namespace

BoundaryPoints boundary_points(const RegionPtr& region, const Box& within, std::int64_t count,
                               RandomStream& random) {
  const Eigen::Index n = within.dimension();
  // The differences must not reach out of the box, where the level need not be defined.
  const Vector reach = Vector::Constant(n, 2.0 * kDifference);
  const Box inner{within.lower + reach, within.upper - reach};
  const auto sampler = sampler_of(region, inner);
  if (!sampler) return {Points(0, n), Points(0, n)};
  const Points from = sampler->sample(static_cast<std::size_t>(count), random);
  const Points to = uniform_points(inner, count, random);
  const Vector level = region->level(to);
  const auto crossing = rows_where(count, [&](Eigen::Index i) { return level[i] > 0.0; });
  const Points point = crossings(*region, from(crossing, Eigen::all), to(crossing, Eigen::all));
  const Points slope = slopes(*region, point);
  const Vector size = slope.rowwise().norm();
  const auto sloping =
      rows_where(size.size(), [&](Eigen::Index i) { return size[i] > 0.0 && std::isfinite(size[i]); });
  BoundaryPoints boundary{point(sloping, Eigen::all), slope(sloping, Eigen::all)};
  boundary.normal.rowwise().normalize();
  return boundary;
}

}  // namespace s2nnds
